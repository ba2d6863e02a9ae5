// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Puts the page together: what arrives goes to the parts that show it, what people do goes to the parts that act on it.
import { Color } from 'three';
import { MeshoptDecoder } from 'meshoptimizer/decoder';
import { Connection } from './connection.js';
import { SavedConnection } from './saved_connection.js';
import { Details } from './details.js';
import { DistanceSlice } from './distances.js';
import { by_id, set_text } from './dom.js';
import { save_glb, save_picture, save_screenshot } from './downloads.js';
import { FramePanel } from './frame_panel.js';
import { icon } from './icons.js';
import { Labels } from './labels.js';
import { lay_out, Tabs } from './layout.js';
import { Legend } from './legend.js';
import { LookBack } from './look_back.js';
import { kModes, SurfaceMaterial } from './material.js';
import { NameTags } from './name_tags.js';
import { Navigation } from './navigation.js';
import { ObjectList } from './objects.js';
import { Picking } from './picking.js';
import { Pointer } from './pointer.js';
import { saved } from './server.js';
import { recall, remember } from './settings.js';
import { Shortcuts } from './shortcuts.js';
import { Stage } from './stage.js';
import { Status, notify } from './status.js';
import { Surface } from './surface.js';
import { Theme } from './theme.js';
import { Timeline } from './timeline.js';
import { Trail } from './trail.js';
import { ViewBar } from './view_bar.js';

const kPanelsEvery_ms = { card: 400, software: 900 };  // every picture of the page costs time, too, where the processor draws

class Page {
  #labels = new Labels();
  #material = new SurfaceMaterial(this.#labels);
  #stage = new Stage(by_id('surface'), this.#material);
  #surface = new Surface(this.#material, MeshoptDecoder, this.#labels);
  #navigation = new Navigation(this.#stage, this.#surface);
  #trail = new Trail(this.#stage.camera);
  #tags = new NameTags(this.#stage, this.#labels);
  #look_back = new LookBack(this.#stage, this.#labels, this.#tags);
  #theme = new Theme();
  #status = new Status();
  #timeline = new Timeline(by_id('timeline'));
  #frame = new FramePanel(by_id('frame'));
  #legend = new Legend(by_id('classes'), this.#labels, () => this.#after_visibility());
  #objects = new ObjectList(by_id('objects'), this.#labels, (id) => this.#select(id, { fly: true }));
  #tabs = new Tabs(document.querySelector('[role=tablist]'));
  #details = new Details(by_id('details'), this.#labels, {
    fly_to: (id) => this.#fly_to(id), show: (id, shown) => this.#show_object(id, shown), close: () => this.#select(0),
  });
  #bar = new ViewBar({
    mode: (mode) => this.#set_mode(mode), camera: (camera) => this.#navigation.set_mode(camera),
    reset: () => this.#navigation.reset(), layer: (name, shown) => this.#set_layer(name, shown), play: () => this.#toggle_play(),
    distances: () => this.#toggle_distances(),
  });
  #picking = new Picking(this.#stage, this.#material);
  #pointer = new Pointer(this.#stage, this.#picking, {
    click: (at, event) => this.#on_click(at, event), pivot: (place) => this.#navigation.set_pivot(place), hover: (id) => this.#hover(id),
    walking: () => this.#navigation.mode === 'walk',
  });
  #play = null;      // the mode "Play", from when it was opened first
  #opening = false;
  #wants_play = false;
  #grows = false;    // the map does
  #slice = null;     // of distances, from when it was opened first
  #measuring = false;
  #scenes = 0;       // how many came
  #layers = { path: true, names: false, backs: false };
  #title = 'map';
  #frame_index = -1;
  #whole = false;  // everything that was there when the page was opened has arrived
  #state = null;  // the newest one
  #panels_pending = false;
  #panels_ms = -Infinity;
  #connection = new (saved === null ? Connection : SavedConnection)({
    status: (state) => this.#status.set_connection(state), scene: (scene) => this.#on_scene(scene), state: (state) => this.#on_state(state),
    objects: (objects) => this.#on_objects(objects), chunks: (chunks) => this.#on_chunks(chunks),
  });

  constructor() {
    this.#stage.map.add(this.#surface.group, this.#trail.group);
    this.#stage.before_draw(() => this.#surface.build());
    by_id('surface').addEventListener('webglcontextrestored', () => { this.#surface.rebuild(); this.#stage.invalidate(); });
    this.#theme.on_change((colors) => this.#apply_colors(colors));
    this.#navigation.on_mode((mode) => this.#on_camera(mode));
    this.#bar.mark_camera('orbit');
    this.#set_mode(recall('mode', 'color'));
    for (const [name, shown] of Object.entries(this.#layers)) this.#set_layer(name, recall(`layer.${name}`, shown));
    this.#add_buttons();
    this.#add_shortcuts();
    this.#details.update(0);
    this.#connection.open();
  }

  #on_scene(scene) {
    this.#title = scene.title;
    this.#whole = false;
    this.#state = null;
    this.#labels.reset(scene);
    this.#surface.reset(scene);
    for (const part of [this.#trail, this.#legend, this.#objects, this.#timeline]) part.reset();
    this.#frame.reset(scene.run);
    this.#navigation.forget();
    ++this.#scenes;
    this.#slice?.close();  // another run has another map
    this.#slice = null;
    this.#bar.mark_distances(false);
    this.#grows = scene.grows;
    this.#leave_play();
    this.#look_back.open(scene);
    this.#status.set_scene(scene);
    this.#bar.allow_mode('confidence', scene.has_confidence !== false);
    if (scene.has_confidence === false && this.#mode === 'confidence') this.#set_mode('color');
    this.#refresh_panels();
    this.#stage.invalidate_soon();
  }

  #on_state(state) {
    this.#stage.set_up(state.up);
    this.#trail.set_path(state.path);
    this.#frame_index = state.frame?.index ?? -1;
    const pose = this.#trail.set_frame(state.frame);
    if (pose) {
      const { map } = this.#stage;
      this.#navigation.set_recording_camera(map.localToWorld(pose.position), pose.rotation.premultiply(map.quaternion));
    }
    this.#bar.allow_camera('follow', pose !== null);
    this.#state = state;
    this.#play?.renew(state.revision);
    this.#refresh_panels();
    this.#stage.invalidate_soon();
  }

  #on_objects(objects) {
    this.#labels.set_objects(objects);
    if (this.#whole) this.#play_if_asked();
    this.#trail.set_box(this.#labels.object(this.#labels.selected));
    this.#refresh_panels();
    this.#stage.invalidate_soon();
  }

  // The address that panoptic play prints ends in #play.
  #play_if_asked() {
    if ((window.location.hash !== '#play' && saved === null) || this.#play || this.#opening || this.#labels.objects.length === 0) return;
    this.#toggle_play();
  }

  #on_chunks(chunks) {
    for (const chunk of chunks) this.#surface.put(chunk);
    const whole = !this.#whole && this.#connection.waiting === 0;
    this.#whole ||= whole;
    if (this.#whole) this.#play_if_asked();
    this.#navigation.frame_map({ whole });
    this.#refresh_panels();
    this.#stage.invalidate_soon();
  }

  // However fast things arrive, the panels are laid out anew only so often; the first time at once.
  #refresh_panels() {
    if (this.#panels_pending) return;
    this.#panels_pending = true;
    const pause_ms = this.#stage.software ? kPanelsEvery_ms.software : kPanelsEvery_ms.card;
    setTimeout(() => {
      this.#panels_pending = false;
      this.#panels_ms = performance.now();
      this.#show_panels();
    }, Math.max(0, this.#panels_ms + pause_ms - performance.now()));
  }

  #show_panels() {
    this.#status.set_counts({ chunks: this.#surface.chunk_count, triangles: this.#surface.triangles, waiting: this.#connection.waiting });
    if (this.#state) {
      this.#frame.update(this.#state.frame);
      this.#timeline.update(this.#state.run);
      this.#status.set_run(this.#state.run);
    }
    set_text(by_id('class-count'), `${this.#legend.update(this.#surface.vertices_of)}`);
    set_text(by_id('object-count'), `${this.#labels.objects.length}`);
    this.#objects.update();
    this.#details.update(this.#surface.count_of(this.#labels.selected));
  }

  #select(id, { fly = false } = {}) {
    this.#labels.select(id);
    this.#trail.set_box(this.#labels.object(id));
    this.#details.update(this.#surface.count_of(id));
    this.#objects.mark(!fly);
    if (fly) this.#fly_to(id);
    this.#stage.invalidate();
  }

  #on_click(at, event) {
    if (this.#play?.active) return this.#play.click(at.x, at.y, { lie: event.shiftKey });
    return this.#select(this.#picking.at(at.x, at.y)?.id ?? 0);
  }

  async #toggle_play() {
    this.#wants_play = !this.#wants_play;
    if (this.#opening) return;
    this.#opening = true;
    try {
      this.#play ??= await this.#open_play();
    } catch (error) {
      notify(`Nothing to play with: ${error.message}`);
    } finally {
      this.#opening = false;
    }
    this.#wants_play &&= this.#play !== null;
    this.#show_play();
  }

  #show_play() {
    const shown = this.#wants_play;
    if (this.#play && this.#play.active !== shown) this.#play.show(shown);
    if (shown && this.#state) this.#play?.renew(this.#state.revision);  // it may have come while Play was opening
    document.body.classList.toggle('playing', shown);
    if (shown) this.#select(0);
    if (shown) this.#look_back.to_now();
    this.#bar.mark_play(shown);
  }

  // Another run has another map.
  #leave_play() {
    this.#wants_play = false;
    this.#show_play();
    this.#play?.close();
    this.#play = null;
    globalThis.panoptic_play = null;
  }

  async #toggle_distances() {
    if (this.#measuring) return;
    this.#measuring = true;
    try {
      this.#slice ??= await this.#open_distances();
      this.#slice?.show(!this.#slice.shown);
      this.#bar.mark_distances(this.#slice?.shown ?? false);
    } catch (error) {
      notify(`No distances: ${error.message}`);
    } finally {
      this.#measuring = false;
    }
  }

  // Null if another scene came meanwhile.
  async #open_distances() {
    notify('Measuring the distances to the nearest surface …');
    const scene = this.#scenes;
    const slice = await DistanceSlice.open(this.#stage);
    if (scene === this.#scenes) return slice;
    slice.close();
    return null;
  }

  async #open_play() {
    notify('Looking where one can walk, sit and lie …');
    const scene = this.#scenes;
    const { Play } = await import('./play/play.js');
    const play = await Play.open({
      stage: this.#stage, surface: this.#surface, material: this.#material, pick: (x, y, film) => this.#picking.at(x, y, film),
      look: (from, at) => this.#navigation.look(from, at), save_picture: (picture, number) => save_picture(picture, `${this.#title}_play`, number),
    }, {
      grows: this.#grows, is_wanted: () => this.#wants_play && scene === this.#scenes,
      why: (reason) => notify(`Play begins by itself as soon as there is a floor. So far: ${reason}`),
    });
    if (play === null || scene !== this.#scenes) return play?.close() ?? null;
    this.#theme.on_change(({ accent }) => { play.color = accent; });
    notify('');  // it waits no longer
    globalThis.panoptic_play = play;  // for those who check where figures are
    return play;
  }

  #hover(id) {
    if (this.#play?.active) id = 0;
    if (this.#labels.hover(id)) this.#stage.invalidate();
    return id === 0 ? '' : this.#labels.name_of(id);
  }

  #fly_to(id) {
    const box = this.#trail.set_box(this.#labels.object(id));
    if (box) this.#navigation.fly_to(box);
  }

  #show_object(id, shown) {
    if (id === 0) return;
    const { id: class_id } = this.#labels.class_of(id);
    if (shown || id < this.#labels.first_thing) this.#labels.show_class(class_id, shown);
    if (id >= this.#labels.first_thing) this.#labels.show_object(id, shown);
    this.#legend.refresh();
    this.#after_visibility();
  }

  #after_visibility() {
    this.#objects.mark(false);
    this.#look_back.refresh();
    this.#details.update(this.#surface.count_of(this.#labels.selected));
    this.#stage.invalidate();
  }

  #mode = 'color';

  #set_mode(mode) {
    if (!kModes.includes(mode)) mode = 'color';
    this.#mode = mode;
    this.#material.mode = mode;
    this.#bar.mark_mode(mode);
    by_id('scale').hidden = mode !== 'confidence';
    remember('mode', mode);
    this.#stage.invalidate();
  }

  #set_layer(name, shown) {
    this.#layers[name] = shown;
    if (name === 'path') this.#trail.path_shown = shown;
    if (name === 'names') this.#tags.shown = shown;
    if (name === 'backs') this.#material.back_sides = shown;
    this.#bar.mark_layer(name, shown);
    remember(`layer.${name}`, shown);
    this.#stage.invalidate();
  }

  #on_camera(mode) {
    this.#bar.mark_camera(mode);
    by_id('crosshair').hidden = mode !== 'walk';
    if (mode === 'walk') notify('W A S D to walk, E and Q up and down, Shift faster. Esc frees the mouse, O goes back to orbit.');
  }

  #apply_colors(colors) {
    const triple = (text) => {
      const { r, g, b } = new Color(text).convertLinearToSRGB();
      return [r, g, b];
    };
    this.#material.set_look({ accent: triple(colors.accent), background: triple(colors.background) });
    this.#trail.set_colors(colors);
    this.#look_back.set_colors(colors);
    this.#stage.set_background(colors.background);
    this.#timeline.redraw();
  }

  #add_buttons() {
    const button = (id, picture, title, on_click) => {
      by_id(id).append(icon(picture));
      by_id(id).title = title;
      if (on_click) by_id(id).addEventListener('click', on_click);
    };
    button('screenshot', 'camera', 'Save a screenshot (X)', () => this.#save_screenshot());
    button('glb', 'download', 'Download the surface as GLB', () => save_glb(this.#title));
    by_id('glb').hidden = saved !== null;  // it is made by the server
    button('theme', 'theme', 'Light or dark (T)', () => this.#theme.toggle());
    button('help-open', 'help', 'Keyboard shortcuts (?)');
    button('toggle-left', 'list', 'Classes and objects');
    button('toggle-right', 'panel', 'Camera image and details');
  }

  #play_keys() {
    const when = (act) => () => this.#play?.active && act(this.#play);
    return {
      a: when((play) => play.add_person()), i: when((play) => play.add_insect()), v: when((play) => play.toggle('alone')), l: when((play) => play.toggle('lie')),
      k: when((play) => play.toggle('film')), z: when((play) => play.clear()), ',': when((play) => play.key('before')), '.': when((play) => play.key('next')), ' ': when((play) => play.key('play')),
    };
  }

  #save_screenshot() {
    return save_screenshot(this.#stage, this.#title, this.#frame_index);
  }

  #add_shortcuts() {
    const toggle = (name) => () => this.#set_layer(name, !this.#layers[name]);
    const selected = () => this.#labels.selected;
    new Shortcuts({
      ...Object.fromEntries(kModes.map((mode, i) => [`${i + 1}`, () => this.#bar.is_allowed(mode) && this.#set_mode(mode)])),
      b: toggle('backs'), p: toggle('path'), n: toggle('names'),
      o: () => this.#navigation.set_mode('orbit'), f: () => this.#navigation.set_mode('walk'), c: () => this.#navigation.set_mode('follow'),
      g: () => this.#toggle_play(), m: () => this.#toggle_distances(), j: () => !this.#play?.active && this.#look_back.toggle(), ...this.#play_keys(),
      r: () => this.#navigation.reset(), t: () => this.#theme.toggle(), x: () => this.#save_screenshot(),
      h: () => this.#show_object(selected(), !this.#labels.is_object_shown(selected())),
      enter: () => this.#fly_to(selected()), escape: () => this.#select(0),
      '/': () => { this.#tabs.open('tab-objects'); this.#objects.focus_search(); },
    }, () => this.#navigation.mode === 'walk');
  }
}

// The server has set a cookie: a token in the address would only end up in pictures of the window.
if (window.location.search) window.history.replaceState(null, '', window.location.pathname + window.location.hash);
MeshoptDecoder.ready.then(() => {
  lay_out();
  try {
    return new Page();
  } catch (error) {
    set_text(by_id('message'), `This browser cannot draw the map (${error.message}). It needs WebGL 2.`);
    throw error;
  }
});
