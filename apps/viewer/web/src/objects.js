// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The objects as a list: search by name, sort, choose.
import { css_color, element, set_text } from './dom.js';

const kOrders = {
  size: ['Largest', (a, b) => volume_of(b) - volume_of(a)],
  name: ['Name', (a, b) => a.name.localeCompare(b.name, 'en', { numeric: true })],
  newest: ['Last seen', (a, b) => b.last_frame - a.last_frame],
  observations: ['Most seen', (a, b) => b.observations - a.observations],
};

export function size_of(object) {
  return [0, 1, 2].map((k) => Math.max(0, object.max_m[k] - object.min_m[k]));
}

function volume_of(object) {
  return size_of(object).reduce((product, side) => product * side, 1);
}

export function best_probability(object) {
  return object.probabilities.find(([class_id]) => class_id === object.class_id)?.[1] ?? 0;
}

// Every word of the search must be somewhere in the name or the class.
export function matches(object, class_name, search) {
  const text = `${object.name} ${class_name}`.toLowerCase();
  return search.toLowerCase().split(/\s+/).every((word) => text.includes(word));
}

export class ObjectList {
  #labels;
  #on_choose;
  #rows = new Map();
  #search;
  #order;
  #list;
  #empty;

  // on_choose(id)
  constructor(root, labels, on_choose) {
    this.#labels = labels;
    this.#on_choose = on_choose;
    this.#search = element('input', { type: 'search', placeholder: 'Search objects', 'aria-label': 'Search objects', on: { input: () => this.update() } });
    this.#order = element('select', { 'aria-label': 'Sort objects', on: { change: () => this.update() } },
      ...Object.entries(kOrders).map(([value, [text]]) => element('option', { value, text })));
    this.#list = element('ul', { class: 'rows', 'aria-label': 'Objects' });
    this.#empty = element('p', { class: 'empty' });
    root.append(element('div', { class: 'tools' }, this.#search, this.#order), element('div', { class: 'scroll' }, this.#list, this.#empty));
  }

  focus_search() {
    this.#search.focus();
    this.#search.select();
  }

  reset() {
    this.#rows.clear();
    this.#list.replaceChildren();
    this.#search.value = '';
  }

  update() {
    const all = this.#labels.objects;
    const found = all.filter((object) => matches(object, this.#labels.class_named(object.class_id).name, this.#search.value))
      .sort((a, b) => kOrders[this.#order.value][1](a, b) || a.id - b.id);
    const ids = new Set(found.map((object) => object.id));
    for (const [id, row] of this.#rows) if (!ids.has(id)) { row.root.remove(); this.#rows.delete(id); }
    found.forEach((object, place) => this.#place(object, place));
    this.#empty.hidden = found.length > 0;
    set_text(this.#empty, all.length === 0 ? 'No objects yet.' : 'Nothing by that name.');
    this.mark(false);
  }

  // Shows which one is selected; `reveal` scrolls to it.
  mark(reveal) {
    for (const [id, row] of this.#rows) {
      const selected = id === this.#labels.selected;
      row.button.setAttribute('aria-pressed', `${selected}`);
      row.root.classList.toggle('off', !this.#labels.is_object_shown(id));
      if (selected && reveal) row.root.scrollIntoView({ block: 'nearest' });
    }
  }

  #place(object, place) {
    let row = this.#rows.get(object.id);
    if (!row) this.#rows.set(object.id, row = this.#made(object.id));
    set_text(row.name, object.name);
    set_text(row.note, `${Math.round(100 * best_probability(object))} %`);
    row.swatch.style.background = css_color(object.color);
    if (this.#list.children[place] !== row.root) this.#list.insertBefore(row.root, this.#list.children[place] ?? null);
  }

  #made(id) {
    const row = { name: element('span', { class: 'name' }), note: element('span', { class: 'muted tabular' }), swatch: element('span', { class: 'swatch round' }) };
    row.button = element('button', { type: 'button', class: 'row choose', on: { click: () => this.#on_choose(id) } }, row.swatch, row.name, row.note);
    row.root = element('li', {}, row.button);
    return row;
  }
}
