// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Names over the objects in the scene: the selected one always, all large enough ones where wanted. Nearer tags win the place.
import { Vector3 } from 'three';
import { by_id, css_color, element, set_text } from './dom.js';
import { size_of } from './objects.js';

const kMostTags = 60;
const kRoom_px = [70, 20];  // tags closer than this to an already placed one are left out

export class NameTags {
  shown = false;
  marks = [];  // [{name, color, min_m, max_m, kind}]: tags of boxes that are no objects of the map
  #stage;
  #labels;
  #root = by_id('name-tags');
  #pool = [];

  constructor(stage, labels) {
    this.#stage = stage;
    this.#labels = labels;
    stage.after_draw(() => this.place());
  }

  place() {
    const wanted = this.#wanted();
    const placed = [];
    for (const object of wanted) {
      if (placed.length >= kMostTags) break;
      const at = this.#stage.project(object.top);
      const selected = object.kind === '' && object.id === this.#labels.selected;
      if (!at || (!selected && placed.some((other) => Math.abs(other.at.x - at.x) < kRoom_px[0] && Math.abs(other.at.y - at.y) < kRoom_px[1]))) continue;
      placed.push({ object, at, selected });
    }
    placed.forEach((tag, i) => this.#show(i, tag));
    for (let i = placed.length; i < this.#pool.length; ++i) this.#pool[i].hidden = true;
  }

  #wanted() {
    const { selected } = this.#labels;
    const eye = this.#stage.camera.position;
    return this.#labels.objects.filter((object) => object.id === selected || (this.shown && this.#labels.is_object_shown(object.id) && !this.#labels.is_faded(object.id) && Math.max(...size_of(object)) > 0.15))
      .concat(this.marks).map((object) => ({ id: object.id, kind: object.kind ?? '', name: object.name, color: object.color, top: this.#top_of(object) }))
      .sort((a, b) => (b.id === selected) - (a.id === selected) || (b.kind !== '') - (a.kind !== '') || a.top.distanceToSquared(eye) - b.top.distanceToSquared(eye));
  }

  // The middle of the box, lifted to its highest corner along `up`.
  #top_of(object) {
    const center = [0, 1, 2].map((k) => (object.min_m[k] + object.max_m[k]) / 2);
    const up = this.#stage.up.toArray();
    const half = size_of(object).reduce((sum, side, k) => sum + Math.abs(side * up[k]) / 2, 0);
    return this.#stage.map.localToWorld(new Vector3(...center).addScaledVector(this.#stage.up, half));
  }

  #show(i, { object, at, selected }) {
    if (!this.#pool[i]) this.#root.append(this.#pool[i] = element('span', { class: 'tag' }));
    const tag = this.#pool[i];
    tag.hidden = false;
    set_text(tag, object.name);
    tag.classList.toggle('selected', selected);
    for (const kind of ['ghost', 'moving']) tag.classList.toggle(kind, object.kind === kind);
    tag.style.setProperty('--color', css_color(object.color));
    tag.style.transform = `translate(${at.x.toFixed(1)}px, ${at.y.toFixed(1)}px) translate(-50%, -110%)`;
  }
}
