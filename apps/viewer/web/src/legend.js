// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The classes that have surface, the largest first, each with a switch; how many objects, and which share of the surface.
import { css_color, element, set_text } from './dom.js';
import { icon } from './icons.js';

export class Legend {
  #labels;
  #on_change;
  #rows = new Map();
  #list;
  #empty;

  constructor(root, labels, on_change) {
    this.#labels = labels;
    this.#on_change = on_change;
    const button = (text, shown) => element('button', { type: 'button', class: 'text-button', text, on: { click: () => this.#show_all(shown) } });
    this.#list = element('ul', { class: 'rows', 'aria-label': 'Classes' });
    this.#empty = element('p', { class: 'empty', text: 'No labels yet.' });
    root.append(element('div', { class: 'tools' }, element('span', { class: 'muted', text: 'Show' }), button('All', true), button('None', false)),
      element('div', { class: 'scroll' }, this.#list, this.#empty));
  }

  reset() {
    this.#rows.clear();
    this.#list.replaceChildren();
  }

  // vertices_of: by panoptic id.
  update(vertices_of) {
    const sums = new Map();
    let all = 0;
    for (const [id, vertices] of vertices_of) {
      const class_id = this.#labels.class_of(id).id;
      const sum = sums.get(class_id) ?? { vertices: 0, objects: 0 };
      sum.vertices += vertices;
      if (id >= this.#labels.first_thing) ++sum.objects;
      sums.set(class_id, sum);
      all += vertices;
    }
    const order = [...sums].sort((a, b) => (a[0] === 0) - (b[0] === 0) || b[1].vertices - a[1].vertices || a[0] - b[0]);
    for (const [class_id, row] of this.#rows) if (!sums.has(class_id)) { row.root.remove(); this.#rows.delete(class_id); }
    order.forEach(([class_id, sum], place) => this.#place(class_id, place, sum, sum.vertices / all));
    this.#empty.hidden = order.length > 0;
    return order.filter(([class_id]) => class_id !== 0).length;
  }

  refresh() {
    for (const [class_id, row] of this.#rows) this.#mark(row, class_id);
  }

  #place(class_id, place, { objects }, share) {
    let row = this.#rows.get(class_id);
    if (!row) this.#rows.set(class_id, row = this.#made(class_id));
    const { is_thing } = this.#labels.class_named(class_id);
    set_text(row.count, is_thing || objects > 0 ? `${objects}` : '');
    row.count.title = objects > 0 ? `${objects} objects` : '';
    set_text(row.share, share < 0.01 ? '<1 %' : `${Math.round(100 * share)} %`);
    row.bar.style.setProperty('--share', share.toFixed(3));
    if (this.#list.children[place] !== row.root) this.#list.insertBefore(row.root, this.#list.children[place] ?? null);
  }

  #made(class_id) {
    const entry = this.#labels.class_named(class_id);
    const row = {
      eye: element('button', { type: 'button', class: 'eye', role: 'switch', 'aria-label': `Show ${entry.name}`, on: { click: () => this.#toggle(class_id) } }),
      count: element('span', { class: 'badge' }),
      share: element('span', { class: 'muted tabular share' }),
      bar: element('span', { class: 'share-bar' }),
    };
    const swatch = element('span', { class: 'swatch' });
    swatch.style.background = css_color(entry.color);
    row.bar.style.background = css_color(entry.color);
    row.root = element('li', { class: 'row', title: 'Double-click: only this class', on: { dblclick: () => this.#only(class_id) } }, swatch,
      element('span', { class: 'name', text: entry.name }), row.count, row.share, row.eye, row.bar);
    this.#mark(row, class_id);
    return row;
  }

  #mark(row, class_id) {
    const shown = this.#labels.is_class_shown(class_id);
    row.eye.setAttribute('aria-checked', `${shown}`);
    row.eye.replaceChildren(icon(shown ? 'eye' : 'eye_off'));
    row.root.classList.toggle('off', !shown);
  }

  #toggle(class_id) {
    this.#labels.show_class(class_id, !this.#labels.is_class_shown(class_id));
    this.#changed();
  }

  #only(class_id) {
    const every = this.#labels.classes.map((entry) => entry.id);
    this.#labels.show_classes(every, false);
    this.#labels.show_class(class_id, true);
    this.#changed();
  }

  #show_all(shown) {
    this.#labels.show_classes(this.#labels.classes.map((entry) => entry.id), shown);
    this.#changed();
  }

  #changed() {
    this.refresh();
    this.#on_change();
  }
}
