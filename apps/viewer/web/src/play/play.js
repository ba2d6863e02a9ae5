// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The mode "Play": figures that live in the map. Loaded when somebody opens it for the first time.
import { Matrix4, Raycaster, Vector2, Vector3 } from 'three';
import { by_id } from '../dom.js';
import { ActorsView } from './actors_view.js';
import { kFiguresLayer } from './camera_view.js';
import { Crew, world_from_figures } from './crew.js';
import { Film } from './film.js';
import { start_recast } from './ground.js';
import { start_physics } from './physics.js';
import { meant } from './places.js';
import { PlayPanel } from './play_panel.js';
import { Plans } from './plans.js';
import { SolidWorld } from './solid_world.js';

const kLongestStep_s = 0.25;
const kPiece_s = 0.1;  // things and people move by turns
const kFirstPeople = 2;
const kFirstInsects = 2;
const kPushed_m_s = 0.75;
const kRenewEvery_ms = 1000;
const kAside_m = 0.3;  // who is put aside farther is told of
const pause = (ms) => new Promise((resolve) => { setTimeout(resolve, ms); });
const kHints = {
  none: 'Add a person, then click the floor, a seat or a bed. A click on a table puts something there.',
  floor: 'On the way.', seat: 'On the way to sit down.', bed: 'On the way to lie down.', no_way: 'There is no way there.', taken: 'That place is taken.',
  no_places: 'The map has nothing to sit or lie on and no tables yet: click the floor. Maps made with networks or --predictions have them.',
  nothing: 'Nobody can go there. Click the floor, a seat, a bed or a table.', full: 'There is no room for one more.', no_walls: 'The map has no wall for insects.',
};

export class Play {
  crew;
  active = false;
  #page;     // {stage, surface, material, labels, pick, save_picture(blob, number)}
  #view = new ActorsView();
  #panel;
  #solid;
  #film;
  #chosen = null;
  #thing = 'cup';
  #lie = false;
  #before_ms = 0;
  #plans;
  #newest = 0;         // snapshot of a map that grows
  #renewing = false;
  #renewed = { times: 0, aside_m: 0 };
  #to_come = kFirstPeople;
  #closed = false;

  // Throws an Error that says why there is nothing to play with. Where the map `grows` it waits for a floor: tells why(text) once a
  // second, and gives null once is_wanted() does not hold.
  static async open(page, { grows = false, why = () => {}, is_wanted = () => true } = {}) {
    const plans = new Plans(grows);
    const [first] = await Promise.all([plans.next(), start_recast(), start_physics()]);
    for (let plan = first; is_wanted(); plan = await plans.next()) {
      if (plan !== null) return new Play(page, plan, plans);
      if (plans.finished) throw new Error(plans.why_not);
      why(plans.why_not);
      await pause(kRenewEvery_ms);
    }
    return null;
  }

  constructor(page, plan, plans) {
    this.#page = page;
    this.#plans = plans;
    this.crew = new Crew(plan);
    this.#view.group.matrixAutoUpdate = false;
    this.#view.group.matrix.copy(world_from_figures(plan.world_from_grid));
    page.stage.camera.layers.enable(kFiguresLayer);
    this.#panel = new PlayPanel(by_id('play-bar'), {
      person: () => this.add_person(), insect: () => this.add_insect(), clear: () => this.clear(), thing: (kind) => this.choose_thing(kind),
      toggle: (name, on) => this.toggle(name, on), frame: (place) => this.#film.go_to(place), save: () => this.#film.save(),
    });
    this.#film = new Film(page, this.#panel);
    this.#solid = new SolidWorld(page.surface, this.#view.group.matrix);
    this.#panel.mark('alone', this.crew.on_their_own);
    this.#panel.mark_thing(this.#thing);
    this.#add_first();
    for (let i = 0; i < kFirstInsects; ++i) this.crew.add_insect();
    const { seats, beds, tables } = this.crew.places;
    this.#panel.say(seats.length + beds.length + tables.length > 0 ? kHints.none : kHints.no_places);
  }

  // The first people come when there is room for them.
  #add_first() {
    while (this.#to_come > 0 && this.add_person() !== null) --this.#to_come;
  }

  // There is a snapshot of this revision: floor, seats and walls become those of now, about once a second.
  async renew(revision) {
    this.#newest = Math.max(this.#newest, revision);
    if (!this.#plans.grows || this.#renewing) return;
    this.#renewing = true;
    try {
      while (this.active && this.#plans.looked_at < this.#newest) {
        const plan = await this.#plans.next();
        if (plan !== null && !this.#closed) this.#take(plan);
        if (this.#plans.looked_at < this.#newest) await pause(kRenewEvery_ms);
      }
    } catch (error) {
      this.#panel.say(`The floor stays as it was seen so far: ${error.message}`);
    } finally {
      this.#renewing = false;
    }
  }

  #take(plan) {
    const { moved, aside_m } = this.crew.renew(plan);
    const { group } = this.#view;
    group.matrix.copy(world_from_figures(plan.world_from_grid));
    group.updateMatrixWorld(true);
    this.#solid.renew(moved);
    this.#renewed = { times: this.#renewed.times + 1, aside_m: Math.max(this.#renewed.aside_m, aside_m) };
    this.#add_first();
    if (aside_m > kAside_m) this.#panel.say(`The floor was another one: somebody was put ${aside_m.toFixed(1)} m aside.`);
    this.#page.stage.invalidate();
  }

  show(shown) {
    this.active = shown;
    this.#panel.shown = shown;
    const { stage } = this.#page;
    if (shown) {
      stage.map.add(this.#view.group);
      this.#view.group.updateMatrixWorld(true);
      this.#before_ms = performance.now();
      stage.animate(() => this.#tick());
      this.renew(this.#newest);
    } else {
      stage.map.remove(this.#view.group);
      this.#film.hide();
    }
    stage.invalidate();
  }

  // For good. It must not be shown.
  close() {
    this.#closed = true;
    this.clear();
    this.#view.update(this.crew, null, [], false);
    this.crew.destroy();
    this.#solid.destroy();
    this.#panel.close();
  }

  set color(color) {
    this.#view.color = color;
  }

  add_person() {
    const person = this.crew.add_person();
    if (person === null) {
      this.#panel.say(kHints.full);
      return null;
    }
    this.#chosen = person;
    this.#page.stage.invalidate();
    return person;
  }

  add_insect() {
    if (this.crew.add_insect() === null) this.#panel.say(kHints.no_walls);
    this.#page.stage.invalidate();
  }

  clear() {
    this.crew.clear();
    this.#to_come = 0;
    this.#chosen = null;
    this.#solid.clear();
    this.#page.stage.invalidate();
  }

  choose_thing(kind) {
    this.#thing = kind;
    this.#panel.mark_thing(kind);
  }

  toggle(name, on = null) {
    if (name === 'film') return (on ?? !this.#film.shown) ? this.#film.show() : this.#film.hide();
    if (name === 'alone') this.crew.on_their_own = on ?? !this.crew.on_their_own;
    if (name === 'lie') this.#lie = on ?? !this.#lie;
    return this.#panel.mark(name, name === 'alone' ? this.crew.on_their_own : this.#lie);
  }

  // For keys: the camera view steps and plays.
  key(name) {
    if (!this.#page.stage.instead) return;
    if (name === 'play') this.#panel.toggle_playing();
    else this.#panel.step(name === 'next' ? 1 : -1);
  }

  // Finds what is under a pixel of the canvas: {direction, surface: {id, place, distance}, figure: {key, distance}}, each null where there
  // is none; null beside the picture of the camera view. `wanted` says by the figure whether the surface matters.
  #under(x_px, y_px, wanted = () => true) {
    const { stage, pick } = this.#page;
    const { clientWidth: width, clientHeight: height } = stage.canvas;
    const film = this.#film.shown ? this.#film.aim(x_px, y_px, width, height) : null;
    if (this.#film.shown && film === null) return null;
    const caster = new Raycaster();
    const aim = film ? new Vector2(film.x, film.y) : new Vector2((2 * x_px) / width - 1, 1 - (2 * y_px) / height);
    caster.setFromCamera(aim, film?.camera ?? stage.camera);
    caster.layers.set(kFiguresLayer);
    const figure = this.#view.hit(caster);
    const surface = wanted(figure) ? pick(x_px, y_px, film) : null;
    if (surface) surface.distance = caster.ray.origin.distanceTo(surface.place);
    return { direction: caster.ray.direction, surface, figure };
  }

  // A click on the canvas, in its pixels.
  click(x_px, y_px, { lie = false } = {}) {
    const under = this.#under(x_px, y_px);
    if (under === null) return;
    const { surface, figure, direction } = under;
    if (figure && (!surface || figure.distance < surface.distance + 0.02)) return void this.#touch(figure.key, direction);
    if (surface) this.#send(surface, lie || this.#lie);
  }

  // For those who check: how far a figure, and the surface there, are under pixels [x, y] of the canvas, in metres, null where there
  // is no figure.
  distances(pixels) {
    return pixels.map(([x, y]) => {
      const under = this.#under(x, y, (figure) => figure !== null);
      return { figure_m: under?.figure?.distance ?? null, surface_m: under?.surface?.distance ?? null };
    });
  }

  // Resolves when what was changed before is on the screen.
  drawn() {
    return this.#page.stage.drawn();
  }

  show_figures(shown) {
    this.#view.group.visible = shown;
    this.#page.stage.invalidate();
  }

  push(thing, speed) {
    this.#solid.push(thing, speed);
  }

  show_frame(place) {
    return this.#panel.go_to(place);
  }

  #touch(key, direction) {
    if (typeof key === 'number') {
      const way = direction.clone().transformDirection(this.#to_figures()).setY(0).normalize().multiplyScalar(kPushed_m_s);
      this.#solid.push(key, way.toArray());
    } else if (this.crew.people.includes(key)) {
      if (this.#chosen === key) key.actor.stand();
      this.#chosen = key;
    }
    this.#page.stage.invalidate();
  }

  #to_figures() {
    return new Matrix4().copy(this.#view.group.matrixWorld).invert();
  }

  #send({ id, place }, lie) {
    const at = place.clone().applyMatrix4(this.#to_figures()).toArray();
    const what = meant(this.crew.places, id, at, (seat) => this.crew.is_free(seat) || this.#chosen?.actor.takes(seat));
    if (what.kind === 'table') return this.put(this.#thing, at);
    if (what.kind === 'nothing') return this.#panel.say(kHints.nothing);
    const person = this.#chosen ?? this.crew.people[0];
    if (!person) return this.#panel.say(kHints.none);
    this.#chosen = person;
    this.crew.on_their_own = false;
    this.#panel.mark('alone', false);
    const { actor } = person;
    const bed = what.kind === 'bed' ? what.place : what.bed;
    if (bed && (lie || what.kind === 'bed')) {
      if (!this.crew.is_free(bed) && !actor.takes(bed)) return this.#panel.say(kHints.taken);
      return this.#panel.say(actor.lie(bed) ? kHints.bed : kHints.no_way);
    }
    const goes = what.kind === 'seat' ? actor.sit(what.place) : actor.go(at);
    return this.#panel.say(goes ? kHints[what.kind] : kHints.no_way);
  }

  // Puts a thing on what is at [x, y, z] in the figures' frame.
  put(kind, at) {
    if (!this.#solid.put(kind, at)) this.#panel.say(kHints.full);
    this.#page.stage.invalidate();
  }

  #tick() {
    if (!this.active) return false;
    const now_ms = performance.now();
    const passed_s = Math.min(kLongestStep_s, (now_ms - this.#before_ms) / 1000);
    this.#before_ms = now_ms;
    this.advance(passed_s);
    return true;
  }

  // Also for those who check: moves everything on by so much time, things as long as people.
  advance(passed_s) {
    for (let left_s = passed_s; left_s > 0; left_s -= kPiece_s) {
      const piece_s = Math.min(left_s, kPiece_s);
      this.crew.update(piece_s);
      this.#solid.step(piece_s, this.crew.people.map(({ actor }) => actor.place));
    }
    this.#solid.set_down(this.crew.insects);
    this.#view.update(this.crew, this.#chosen, this.#solid.things, !this.#film.shown);
  }

  // The picture as it is now, for those who keep it in the same turn.
  picture_now() {
    this.#page.stage.draw_now();
  }

  // Looks from a place towards another one, [x, y, z] in the figures' frame.
  look(from, at) {
    const [eye, target] = [from, at].map((place) => new Vector3(...place).applyMatrix4(this.#view.group.matrixWorld));
    this.#page.look(eye, target);
  }

  // Where everybody is, in the figures' frame: what the tests look at.
  log() {
    return {
      people: this.crew.people.map((person) => {
        const joints = this.#view.joints.get(person);
        const { state, place, heading } = person.actor;
        return { number: person.number, state, place: [...place], world: new Vector3(...place).applyMatrix4(this.#view.group.matrix).toArray(), heading, pelvis: joints?.pelvis.toArray(), ankles: joints?.legs.map((leg) => leg.ankle.toArray()), ankle_m: person.shape.ankle };
      }),
      insects: this.crew.insects.map(({ insect: { place: [x, y, z] }, wall, lift_m = 0 }) => new Vector3(x, y + lift_m, z).applyMatrix4(wall.to_figures).toArray()),
      things: this.#solid.things,
      plan: { revision: this.#plans.revision, finished: this.#plans.finished, ...this.#renewed },
    };
  }
}
