// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// An insect that crawls over the navigation mesh of one wall: from place to place, with rests. Coordinates are those of the wall's
// mesh: y leads out of the wall.
import rules from './rules.json' with { type: 'json' };

const { speed_m_s: kSpeed_m_s, turn_rad_s: kTurn_rad_s, turns_first_rad: kTurnsFirst_rad, rests_s: kRest_s, farthest_m: kFarthest_m, tries: kTries } = rules.insect;

const wrapped = (angle) => Math.atan2(Math.sin(angle), Math.cos(angle));

export class Insect {
  place;
  heading = 0;
  travelled_m = 0;
  #mesh;
  #random;
  #corners = [];
  #rest_s = 0;
  #speed;

  constructor(mesh, at, random) {
    this.#mesh = mesh;
    this.#random = random;
    this.place = [...at];
    this.heading = random() * 2 * Math.PI;
    this.#speed = kSpeed_m_s[0] + (kSpeed_m_s[1] - kSpeed_m_s[0]) * random();
  }

  // On another mesh; where it was going is forgotten.
  move_to(mesh, at, heading) {
    this.#mesh = mesh;
    this.place = [...at];
    this.heading = heading;
    this.#corners = [];
  }

  // To a place of its wall; false if there is no way.
  go(to) {
    const way = this.#mesh.way(this.place, to);
    if (way === null) return false;
    this.#corners = way.slice(1);
    this.#rest_s = 0;
    return true;
  }

  #choose() {
    for (let i = 0; i < kTries; ++i) {
      const to = this.#mesh.random();
      if (to && Math.hypot(to[0] - this.place[0], to[2] - this.place[2]) < kFarthest_m && this.go(to)) return;
    }
    this.#rest_s = kRest_s[1];
  }

  update(passed_s) {
    this.#rest_s -= passed_s;
    if (this.#rest_s > 0) return;
    if (this.#corners.length === 0) return this.#choose();
    const [to] = this.#corners;
    const way = [to[0] - this.place[0], to[1] - this.place[1], to[2] - this.place[2]];
    const left = Math.hypot(...way);
    const off = wrapped(Math.atan2(way[0], way[2]) - this.heading);
    const turn = Math.min(Math.abs(off), kTurn_rad_s * passed_s);
    if (left > 1e-4) this.heading = wrapped(this.heading + Math.sign(off) * turn);
    this.travelled_m += 0.02 * turn;
    if (left > 1e-4 && Math.abs(off) - turn > kTurnsFirst_rad) return;  // turns first
    const step = Math.min(left, this.#speed * passed_s);
    for (let k = 0; k < 3; ++k) this.place[k] += left > 0 ? (way[k] * step) / left : 0;
    this.travelled_m += step;
    if (left - step > 1e-4) return;
    this.#corners.shift();
    if (this.#corners.length > 0) return;
    this.#rest_s = kRest_s[0] + (kRest_s[1] - kRest_s[0]) * this.#random();
  }
}
