// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The controls over the canvas: what the surface shows, how one moves, which layers are drawn.
import { by_id, element } from './dom.js';
import { icon } from './icons.js';

export const kModeNames = { color: 'Colour', class: 'Class', panoptic: 'Panoptic', normals: 'Normals', confidence: 'Confidence' };

// One of several: radio buttons in looks and for the keyboard. choose(value) calls `on_choose`; mark(value) only shows it.
class Choice {
  #buttons = new Map();

  constructor(root, entries, on_choose) {
    for (const [value, { text, picture, label, title }] of Object.entries(entries)) {
      const button = element('button', { type: 'button', role: 'radio', 'aria-checked': 'false', 'aria-label': label, title, on: { click: () => on_choose(value) } },
        picture ? icon(picture) : null, text ?? null);
      this.#buttons.set(value, button);
      root.append(button);
    }
    root.addEventListener('keydown', (event) => {
      const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
      if (!step) return;
      const all = [...this.#buttons.values()].filter((button) => !button.disabled);
      const next = all[(all.indexOf(document.activeElement) + step + all.length) % all.length];
      next.focus();
      next.click();
      event.preventDefault();
    });
  }

  allow(value, allowed) {
    this.#buttons.get(value).disabled = !allowed;
  }

  is_allowed(value) {
    return !this.#buttons.get(value).disabled;
  }

  mark(value) {
    for (const [name, button] of this.#buttons) {
      button.setAttribute('aria-checked', `${name === value}`);
      button.tabIndex = name === value ? 0 : -1;
    }
  }
}

export class ViewBar {
  #modes;
  #cameras;
  #switches = new Map();
  #play;
  #distances;

  // actions: {mode(name), camera(name), reset(), layer(name, shown), distances(), play()}
  constructor(actions) {
    const keys = Object.fromEntries(Object.entries(kModeNames).map(([name, text], i) => [name, { text, label: text, title: `${text} (${i + 1})` }]));
    this.#modes = new Choice(by_id('modes'), keys, actions.mode);
    const bar = by_id('camera-bar');
    const cameras = element('div', { class: 'segmented', role: 'radiogroup', 'aria-label': 'Camera' });
    this.#cameras = new Choice(cameras, {
      orbit: { text: 'Orbit', picture: 'orbit', label: 'Orbit', title: 'Turn around a point (O)' },
      walk: { text: 'Walk', picture: 'walk', label: 'Walk', title: 'First person: W A S D and the mouse (F)' },
      follow: { text: 'Follow', picture: 'follow', label: 'Follow the camera', title: 'Behind the recording camera (C)' },
    }, actions.camera);
    const layers = element('div', { class: 'segmented' },
      element('button', { type: 'button', 'aria-label': 'Reset the view', title: 'Reset the view (R)', on: { click: actions.reset } }, icon('home')));
    const layer = (name, picture, label, key) => {
      const button = element('button', { type: 'button', 'aria-pressed': 'false', 'aria-label': label, title: `${label} (${key})`,
        on: { click: () => actions.layer(name, button.getAttribute('aria-pressed') !== 'true') } }, icon(picture));
      this.#switches.set(name, button);
      layers.append(button);
    };
    layer('path', 'path', 'Camera path', 'P');
    layer('names', 'tag', 'Names', 'N');
    layer('backs', 'back', 'Back sides', 'B');
    this.#distances = element('button', { type: 'button', 'aria-pressed': 'false', title: 'Distances to the nearest surface (M)',
      'aria-label': 'Distances to the nearest surface', on: { click: actions.distances } }, icon('rings'));
    layers.append(this.#distances);
    this.#play = element('button', { type: 'button', 'aria-pressed': 'false', title: 'Figures that live in the map (G)', 'aria-label': 'Play', on: { click: actions.play } }, icon('person'), 'Play');
    bar.append(cameras, layers, element('div', { class: 'segmented' }, this.#play));
  }

  allow_mode(mode, allowed) {
    this.#modes.allow(mode, allowed);
  }

  is_allowed(mode) {
    return this.#modes.is_allowed(mode);
  }

  allow_camera(camera, allowed) {
    this.#cameras.allow(camera, allowed);
  }

  mark_mode(mode) {
    this.#modes.mark(mode);
  }

  mark_camera(camera) {
    this.#cameras.mark(camera);
  }

  mark_play(on) {
    this.#play.setAttribute('aria-pressed', `${on}`);
  }

  mark_distances(on) {
    this.#distances.setAttribute('aria-pressed', `${on}`);
  }

  mark_layer(name, shown) {
    this.#switches.get(name).setAttribute('aria-pressed', `${shown}`);
  }
}
