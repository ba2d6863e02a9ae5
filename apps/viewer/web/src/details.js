// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Everything that is known about the selected object, or about the stuff that was clicked.
import { css_color, element } from './dom.js';
import { icon } from './icons.js';
import { best_probability, size_of } from './objects.js';

const kMostBars = 6;

export function size_text(object) {
  return `${size_of(object).map((side) => side.toFixed(2)).join(' × ')} m`;
}

function fact(name, value) {
  return value === null ? null : element('div', {}, element('dt', { text: name }), element('dd', { class: 'tabular', text: value }));
}

export class Details {
  #root;
  #labels;
  #actions;
  #shown_as = '';

  // actions: {fly_to(id), show(id, shown), close()}
  constructor(root, labels, actions) {
    this.#root = root;
    this.#labels = labels;
    this.#actions = actions;
  }

  // vertices: of the surface with this id, borders of chunks counted twice.
  update(vertices) {
    const id = this.#labels.selected;
    const object = this.#labels.object(id);
    // Rebuilding the same content would take the focus from the button that was just pressed, and be read out again.
    const signature = JSON.stringify([id, object, object ? 0 : vertices, this.#labels.is_object_shown(id), this.#labels.class_of(id).name]);
    if (signature === this.#shown_as) return;
    this.#shown_as = signature;
    const focused = this.#root.contains(document.activeElement) ? document.activeElement.dataset.action : null;
    this.#root.replaceChildren(...(id === 0 ? this.#nothing() : this.#selected(id, object, vertices)));
    if (focused) this.#root.querySelector(`[data-action="${focused}"]`)?.focus();
  }

  #nothing() {
    return [element('h2', { text: 'Selection' }), element('p', { class: 'empty', text: 'Click a surface, or choose an object in the list.' })];
  }

  #selected(id, object, vertices) {
    const entry = this.#labels.class_of(id);
    const swatch = element('span', { class: 'swatch round large' });
    swatch.style.background = css_color(this.#labels.color_of(id));
    const head = element('div', { class: 'details-head' }, swatch,
      element('div', {}, element('h2', { id: 'selected-name', text: this.#labels.name_of(id) }),
        element('p', { class: 'muted', id: 'selected-class', text: object ? `class ${entry.name}` : entry.is_thing ? 'object without class evidence' : 'background' })),
      this.#button('close', 'close', 'Clear the selection', () => this.#actions.close()));
    if (!object) return [head, element('dl', { class: 'facts' }, fact('Panoptic id', `${id}`), fact('Vertices', vertices.toLocaleString('en')))];
    const shown = this.#labels.is_object_shown(id);
    const buttons = element('div', { class: 'buttons' }, this.#button('fly', 'target', 'Fly to the object', () => this.#actions.fly_to(id), 'Fly to'),
      this.#button('show', shown ? 'eye_off' : 'eye', shown ? 'Hide the object' : 'Show the object', () => this.#actions.show(id, !shown), shown ? 'Hide' : 'Show'));
    return [head, buttons, this.#bars(object), this.#facts(object)];
  }

  #facts(object) {
    const center = [0, 1, 2].map((k) => ((object.min_m[k] + object.max_m[k]) / 2).toFixed(2));
    return element('dl', { class: 'facts' }, fact('Size', size_text(object)), fact('Centre', `${center.join(', ')} m`),
      fact('Confidence', `${(100 * best_probability(object)).toFixed(1)} %`), fact('Seen in frames', `${object.first_frame} to ${object.last_frame}`),
      fact('Observations', object.observations.toLocaleString('en')), fact('Vertices', object.vertices.toLocaleString('en')),
      fact('Panoptic id', `${object.id}`));
  }

  #bars(object) {
    const best = [...object.probabilities].sort((a, b) => b[1] - a[1] || a[0] - b[0]).slice(0, kMostBars).filter(([, p], i) => i === 0 || p >= 0.0005);
    return element('ul', { class: 'bars', 'aria-label': 'Class probabilities' }, ...best.map(([class_id, p]) => {
      const entry = this.#labels.class_named(class_id);
      const bar = element('span', { class: 'bar' });
      bar.style.setProperty('--share', p.toFixed(4));
      bar.style.setProperty('--color', css_color(entry.color));
      return element('li', {}, element('span', { class: 'name', text: entry.name }), bar, element('span', { class: 'muted tabular', text: `${(100 * p).toFixed(1)} %` }));
    }));
  }

  #button(action, picture, label, on_click, text) {
    return element('button', { type: 'button', class: text ? 'button' : 'icon-button', 'data-action': action, 'aria-label': label, title: label, on: { click: on_click } },
      icon(picture), text ?? null);
  }
}
