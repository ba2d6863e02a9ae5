// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The surface of the map as something solid: things stand on it, and insects are set down on it. Parts of it are handed to the
// physics when something is near them.
import { Box3, Quaternion, Vector3 } from 'three';
import { Physics } from './physics.js';

const kAround_m = 0.9;
const kWallBefore_m = 0.04;
const kTouching_m = 0.004;  // nearer the ray began inside of something
const kWalker_m = 1.6;

export class SolidWorld {
  #physics = new Physics();
  #surface;
  #to_map;    // from the figures' frame
  #kinds = [];  // by number; null when it is gone

  constructor(surface, to_map) {
    this.#surface = surface;
    this.#to_map = to_map;
  }

  // Puts a thing on what is at [x, y, z]. False if there are too many.
  put(kind, at) {
    this.#make_solid(at);
    const number = this.#physics.put(kind, at, at[0] * 7 + at[2] * 3);
    if (number !== null) this.#kinds[number] = kind;
    return number !== null;
  }

  push(number, speed) {
    if (this.#kinds[number]) this.#physics.push(number, speed);
  }

  clear() {
    this.#kinds.forEach((_, number) => this.#physics.remove(number));
    this.#kinds = this.#kinds.map(() => null);
  }

  // people: their places.
  step(passed_s, people) {
    if (this.#kinds.every((kind) => kind === null)) return;
    this.#physics.walkers(people, kWalker_m);
    this.#physics.step(passed_s);
  }

  destroy() {
    this.#physics.destroy();
  }

  // After `to_map` was changed: `moved` is from the frame so far. Things stay where they are in the map, on its surface of now, or fall.
  renew(moved) {
    const [by, turn] = [new Vector3(), new Quaternion()];
    moved.decompose(by, turn, new Vector3());
    this.#physics.move(turn.toArray(), by.toArray());
    for (const { place } of this.things) this.#make_solid(place);
  }

  // {key, kind, place, turn, asleep} of each.
  get things() {
    return this.#kinds.flatMap((kind, key) => {
      const at = kind === null ? null : this.#physics.at(key);
      if (at === null) this.#kinds[key] = null;
      return at === null ? [] : [{ key, ...at }];
    });
  }

  #make_solid([x, y, z], below_m = y + 0.3) {
    const box = new Box3(new Vector3(x - kAround_m, y - below_m, z - kAround_m), new Vector3(x + kAround_m, y + 0.5, z + kAround_m)).applyMatrix4(this.#to_map);
    const from_map = this.#to_map.clone().invert();
    const point = new Vector3();
    const chunks = this.#surface.chunks_in(box);
    for (const { places } of chunks) {
      for (let i = 0; i < places.length; i += 3) point.fromArray(places, i).applyMatrix4(from_map).toArray(places, i);
    }
    this.#physics.solid(chunks);
  }

  // The walls' navigation meshes are near the surface; what is drawn and measured is the surface: insects stand on that.
  set_down(insects) {
    for (const item of insects) {
      const at = new Vector3(...item.insect.place).applyMatrix4(item.wall.to_figures);
      if (!item.solid_at || item.solid_at.distanceTo(at) > 0.5 * kAround_m) {
        this.#make_solid(at.toArray(), kAround_m);
        item.solid_at = at;
        this.#physics.settle();
      }
      const out = new Vector3(0, 1, 0).transformDirection(item.wall.to_figures);
      const from = at.clone().addScaledVector(out, kWallBefore_m);
      const hit = this.#physics.cast(from.toArray(), out.clone().negate().toArray(), 2 * kWallBefore_m);
      item.lift_m = hit === null || hit < kTouching_m ? 0 : kWallBefore_m - hit;
    }
  }
}
