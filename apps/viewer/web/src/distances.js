// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A level slice through the distances to the nearest surface, drawn in the map at the height that a slider says.
import { DoubleSide, Group, Matrix4, Mesh, MeshBasicMaterial, PlaneGeometry, SRGBColorSpace, Texture } from 'three';
import { by_id, element, set_text } from './dom.js';
import { json_of, picture_of } from './server.js';
import { notify } from './status.js';
import { kLineLayer } from './trail.js';

const kFirstHeight_m = 0.5;

// The place of the height that is nearest.
export function nearest_place(heights_m, height_m) {
  let best = 0;
  heights_m.forEach((height, place) => { if (Math.abs(height - height_m) < Math.abs(heights_m[best] - height_m)) best = place; });
  return best;
}

export class DistanceSlice {
  group = new Group();
  shown = false;
  #about;
  #plane;
  #stage;
  #panel = by_id('distances');
  #slider;
  #height = element('output', { class: 'tabular' });
  #place = -1;
  #wanted = -1;
  #closed = false;

  // Throws Error with the server's reason where a map has no distances.
  static async open(stage) {
    const slice = new DistanceSlice(stage, await json_of('/api/play/distances.json'));
    try {
      await slice.#show_place(nearest_place(slice.#about.heights_m, kFirstHeight_m));
    } catch (error) {
      slice.close();
      throw error;
    }
    return slice;
  }

  constructor(stage, about) {
    const { low_m, high_m, heights_m, cap_m, line_m, world_from_grid } = about;
    this.#stage = stage;
    this.#about = about;
    const material = new MeshBasicMaterial({ map: new Texture(), transparent: true, side: DoubleSide, depthWrite: false, toneMapped: false });
    this.#plane = new Mesh(new PlaneGeometry(high_m[0] - low_m[0], high_m[1] - low_m[1]), material);
    this.#plane.position.set((low_m[0] + high_m[0]) / 2, (low_m[1] + high_m[1]) / 2, 0);
    this.#plane.layers.set(kLineLayer);
    this.group.add(this.#plane);
    this.group.matrixAutoUpdate = false;
    this.group.matrix.copy(new Matrix4().set(...world_from_grid));
    this.group.visible = false;
    this.#slider = element('input', { type: 'range', min: 0, max: heights_m.length - 1, step: 1, 'aria-label': 'Height of the slice',
      on: { input: () => this.#on_slider() } });
    this.#panel.replaceChildren(element('span', { text: 'Height' }), this.#slider, this.#height,
      element('span', { text: 'Distance 0' }), element('i'), element('span', { text: `${cap_m} m`, title: `A line every ${line_m} m; grey: behind surfaces` }));
    stage.map.add(this.group);
  }

  get height_m() {
    return this.#about.heights_m[this.#place];
  }

  show(shown) {
    this.shown = shown;
    this.group.visible = shown;
    this.#panel.hidden = !shown;
    this.#stage.invalidate();
  }

  close() {
    this.#closed = true;
    this.show(false);
    this.group.removeFromParent();
    this.#plane.geometry.dispose();
    this.#plane.material.map.dispose();
    this.#plane.material.dispose();
  }

  // One picture at a time; of those that were asked for meanwhile the last.
  async #show_place(place) {
    const busy = this.#wanted >= 0;
    this.#wanted = place;
    if (busy) return;
    try {
      while (this.#wanted !== this.#place && !this.#closed) {
        const next = this.#wanted;
        const image = await picture_of(`/api/play/slice.png?n=${next}`);
        if (!this.#closed) this.#put(next, image);
      }
    } finally {
      this.#wanted = -1;
    }
  }

  async #on_slider() {
    try {
      await this.#show_place(Number(this.#slider.value));
    } catch (error) {
      if (this.#closed) return;
      this.#slider.value = this.#place;  // that is what is drawn
      notify(`No slice here: ${error.message}`);
    }
  }

  #put(place, image) {
    const { material } = this.#plane;
    material.map.dispose();
    material.map = new Texture(image);
    Object.assign(material.map, { colorSpace: SRGBColorSpace, flipY: false, needsUpdate: true });
    this.#place = place;
    this.#plane.position.z = this.height_m;
    this.#slider.value = place;
    set_text(this.#height, `${this.height_m.toFixed(2)} m`);
    this.#stage.invalidate();
  }
}
