// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The bar of the mode "Play": who comes and goes, what a click on a table puts there, and the camera view with its frames.
import { element, set_text } from '../dom.js';
import { icon } from '../icons.js';

const kThingNames = { cup: 'Cup', teapot: 'Teapot', plant: 'Plant' };
const kFrameEvery_ms = 120;

export class PlayPanel {
  #root;
  #hint = element('p', { class: 'play-hint', role: 'status', 'aria-label': 'Play' });
  #toggles = new Map();
  #things = new Map();
  #film;
  #slider;
  #caption = element('span', { class: 'muted tabular' });
  #frames = 0;
  #place = 0;
  #playing = 0;
  #actions;

  // actions: {person(), insect(), clear(), thing(kind), toggle(name, on), frame(place) -> promise, save()}
  constructor(root, actions) {
    this.#root = root;
    this.#actions = actions;
    const act = (text, picture, title, on_click) => element('button', { type: 'button', title, 'aria-label': title.replace(/ \(.*/, ''), on: { click: on_click } }, icon(picture), text);
    const who = element('div', { class: 'segmented' }, act('Person', 'person', 'Add a person (A)', actions.person), act('Insect', 'insect', 'Add an insect (I)', actions.insect),
      act('', 'trash', 'Remove all figures and things (Z)', actions.clear));
    const things = element('div', { class: 'segmented', role: 'group', 'aria-label': 'What a click on a table puts there' });
    for (const [kind, text] of Object.entries(kThingNames)) {
      const button = element('button', { type: 'button', 'aria-pressed': 'false', title: `A click on a table puts a ${text.toLowerCase()} there`, on: { click: () => actions.thing(kind) }, text });
      this.#things.set(kind, button);
      things.append(button);
    }
    const how = element('div', { class: 'segmented' });
    for (const [name, text, title] of [['alone', 'On their own', 'Figures decide for themselves (V)'], ['lie', 'Lie down', 'A click on a sofa means lying down (L)'], ['film', 'Camera view', 'Figures in the recorded images (K)']]) {
      const button = element('button', { type: 'button', 'aria-pressed': 'false', title, text, on: { click: () => actions.toggle(name, button.getAttribute('aria-pressed') !== 'true') } });
      this.#toggles.set(name, button);
      how.append(button);
    }
    this.#film = this.#make_film(act);
    root.append(element('div', { class: 'play-rows' }, who, things, how), this.#film, this.#hint);
  }

  #make_film(act) {
    this.#slider = element('input', { type: 'range', min: 0, max: 0, value: 0, 'aria-label': 'Frame of the recording', on: { input: () => this.go_to(Number(this.#slider.value)) } });
    return element('div', { class: 'segmented film', hidden: true }, act('', 'before', 'Frame before (,)', () => this.go_to(this.#place - 1)),
      act('', 'play', 'Play or stop the frames (Space)', () => this.toggle_playing()), act('', 'next', 'Next frame (.)', () => this.go_to(this.#place + 1)), this.#slider, this.#caption,
      act('', 'camera', 'Save this picture', () => this.#actions.save()));
  }

  set shown(shown) {
    this.#root.hidden = !shown;
    if (!shown) this.stop_playing();
  }

  close() {
    this.shown = false;
    this.#root.replaceChildren();
  }

  say(text) {
    set_text(this.#hint, text);
  }

  mark(name, on) {
    this.#toggles.get(name).setAttribute('aria-pressed', `${on}`);
    if (name !== 'film') return;
    this.#film.hidden = !on;
    if (!on) this.stop_playing();
  }

  mark_thing(kind) {
    for (const [name, button] of this.#things) button.setAttribute('aria-pressed', `${name === kind}`);
  }

  set_frames(count) {
    this.#frames = count;
    this.#slider.max = `${Math.max(0, count - 1)}`;
  }

  get place() {
    return this.#place;
  }

  step(by) {
    return this.go_to(this.#place + by);
  }

  async go_to(place) {
    this.#place = Math.max(0, Math.min(this.#frames - 1, place));
    this.#slider.value = `${this.#place}`;
    const number = await this.#actions.frame(this.#place);
    if (number !== null) set_text(this.#caption, `frame ${number}`);
  }

  toggle_playing() {
    if (this.#playing) return this.stop_playing();
    const id = this.#playing = Symbol('playing');
    const go = async () => {
      while (this.#playing === id) {
        if (this.#place + 1 >= this.#frames) return this.stop_playing();
        const next = new Promise((resolve) => { setTimeout(resolve, kFrameEvery_ms); });
        await this.go_to(this.#place + 3);
        await next;
      }
      return null;
    };
    return go();
  }

  stop_playing() {
    this.#playing = 0;
  }
}
