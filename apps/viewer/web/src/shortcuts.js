// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Keys, and the overlay that lists them. Keys do nothing while somebody types, and never with Ctrl, Alt or Meta.
import { by_id, element } from './dom.js';

const kKeys = [
  ['Surface', [['1 – 5', 'Colour, class, panoptic, normals, confidence'], ['B', 'Back sides'], ['P', 'Camera path'], ['N', 'Names'], ['M', 'Distances to the nearest surface'], ['J', 'Play what happened, or pause']]],
  ['Camera', [['O', 'Orbit'], ['F', 'Walk (first person)'], ['C', 'Follow the recording camera'], ['R', 'Reset the view'],
    ['W A S D', 'Walk; E and Q up and down, Shift faster'], ['Double-click', 'Turn around this point']]],
  ['Objects', [['Click', 'Select'], ['Enter', 'Fly to the selection'], ['H', 'Hide or show the selection'], ['/', 'Search'], ['Esc', 'Clear the selection']]],
  ['Play', [['G', 'Play: figures in the map'], ['A  I', 'Add a person, an insect'], ['V', 'Figures decide for themselves'], ['L', 'Lie down instead of sitting (or Shift and click)'],
    ['K', 'Camera view'], [',  .  Space', 'Frame before, next frame, play the frames'], ['Z', 'Remove all figures and things']]],
  ['Page', [['T', 'Light or dark'], ['X', 'Screenshot'], ['?', 'This list']]],
];

const typing = (target) => (target instanceof HTMLInputElement && target.type !== 'range') || target instanceof HTMLSelectElement || target instanceof HTMLTextAreaElement;

export class Shortcuts {
  #dialog = by_id('help');

  // actions: key -> function; keys as KeyboardEvent.key has them, lower case. walking() tells whether W A S D E Q are taken.
  constructor(actions, walking) {
    this.#dialog.append(element('header', {}, element('h2', { text: 'Keyboard shortcuts' }),
      element('button', { type: 'button', class: 'button', text: 'Close', on: { click: () => this.#dialog.close() } })),
    element('div', { class: 'help-columns' }, ...kKeys.map(([title, rows]) => element('section', {}, element('h3', { text: title }),
      element('dl', {}, ...rows.map(([keys, text]) => element('div', {}, element('dt', {}, element('kbd', { text: keys })), element('dd', { text }))))))));
    this.#dialog.addEventListener('click', (event) => { if (event.target === this.#dialog) this.#dialog.close(); });
    by_id('help-open').addEventListener('click', () => this.toggle());
    window.addEventListener('keydown', (event) => this.#on_key(event, actions, walking));
  }

  toggle() {
    this.#dialog.open ? this.#dialog.close() : this.#dialog.showModal();
  }

  #on_key(event, actions, walking) {
    if (event.ctrlKey || event.altKey || event.metaKey || event.repeat || typing(event.target)) return;
    const key = event.key.toLowerCase();
    if (key === '?') return this.toggle();
    if (this.#dialog.open || (walking() && 'wasdeq'.includes(key))) return;
    if (key === 'enter' && event.target instanceof HTMLButtonElement) return;
    const action = actions[key];
    if (!action) return;
    event.preventDefault();
    action();
  }
}
