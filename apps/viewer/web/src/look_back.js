// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The map as it was at an earlier time: a slider, what it shows in the map, and the names over it. Nothing of it is there for a map
// without a history, and at the end of the slider the map is that of now.
import { by_id } from './dom.js';
import { Past } from './past.js';
import { ghost_text, left_out_text, time_text } from './past_text.js';
import { PastView } from './past_view.js';
import { json_of } from './server.js';
import { notify } from './status.js';
import { TimeSlider } from './time_slider.js';

export class LookBack {
  #stage;
  #labels;
  #tags;
  #slider;
  #past = null;
  #view = null;  // from when an earlier time was shown first
  #colors = null;
  #scenes = 0;

  constructor(stage, labels, tags) {
    this.#stage = stage;
    this.#labels = labels;
    this.#tags = tags;
    this.#slider = new TimeSlider(by_id('time-slider'), stage, (time_s) => this.#show(time_s));
  }

  // Another scene.
  async open({ has_history }) {
    const scene = ++this.#scenes;
    this.#close();
    if (!has_history) return;
    try {
      const past = new Past(await json_of('/api/history'));
      if (scene !== this.#scenes) return;
      this.#past = past;
      this.#slider.open(past);
    } catch (error) {
      notify(`No look back in time: ${error.message}`);
    }
  }

  set_colors(colors) {
    this.#colors = colors;
    this.#view?.set_colors(colors);
  }

  // Plays, or pauses.
  toggle() {
    this.#slider.toggle();
  }

  to_now() {
    if (this.#past !== null) this.#slider.set(null);
  }

  // Classes were shown or hidden.
  refresh() {
    if (this.#view === null) return;
    this.#view.choose(({ class_id }) => this.#labels.is_class_shown(class_id));
    this.#show(this.#slider.time_s);
  }

  #show(time_s) {
    const now = time_s === null;
    this.#labels.set_faded(now ? new Set() : this.#past.not_yet(time_s));
    this.#tags.marks = [];
    if (!now) this.#draw(time_s);
    if (this.#view !== null) this.#view.group.visible = !now;
    this.#slider.say(time_text(this.#past, time_s), left_out_text(this.#past.left_out));
    this.#stage.invalidate();
  }

  #draw(time_s) {
    const shown = ({ class_id }) => this.#labels.is_class_shown(class_id);
    const ghosts = this.#past.ghosts(time_s).filter(shown);
    const moves = this.#past.moves(time_s).filter(({ from }) => shown(from));
    const moving = this.#past.moving(time_s).filter(({ track }) => shown(track));
    this.#view ??= this.#made_view();
    this.#view.show(time_s, { ghosts, moves, moving });
    const class_of = ({ class_id }) => this.#labels.class_named(class_id);
    this.#tags.marks = [
      ...moving.map(({ track, box }) => ({ ...box, name: track.class_id === 0 ? 'something moves' : class_of(track).name, color: class_of(track).color, kind: 'moving' })),
      ...ghosts.map((object) => ({ ...object, name: ghost_text(class_of(object).name, object, this.#past.start_s), kind: 'ghost' })),
    ];
  }

  #made_view() {
    const view = new PastView(this.#past, this.#stage.up.toArray());
    view.set_colors(this.#colors);
    view.choose(({ class_id }) => this.#labels.is_class_shown(class_id));
    this.#stage.map.add(view.group);
    return view;
  }

  #close() {
    this.#slider.open(null);
    this.#view?.close();
    this.#view = null;
    this.#past = null;
    this.#tags.marks = [];
    this.#labels.set_faded(new Set());
  }
}
