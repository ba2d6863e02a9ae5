// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The true surface of a simulated home: the vertices of its mesh, a centimetre apart, found by place.
import { readdirSync, readFileSync } from 'node:fs';
import { join } from 'node:path';

const kCell_m = 0.1;
const kVertexBytes = 16;

export class Truth {
  #cells = new Map();

  constructor(folder) {
    const file = readdirSync(folder).find((name) => name.endsWith('_vh_clean_2.ply'));
    const bytes = readFileSync(join(folder, file));
    const end = bytes.indexOf('end_header\n') + 'end_header\n'.length;
    const count = Number(/element vertex (\d+)/.exec(bytes.subarray(0, end).toString())[1]);
    for (let i = 0; i < count; ++i) {
      const at = end + kVertexBytes * i;
      const point = [0, 4, 8].map((offset) => bytes.readFloatLE(at + offset));
      const key = this.#key(point);
      const cell = this.#cells.get(key);
      if (cell) cell.push(point);
      else this.#cells.set(key, [point]);
    }
  }

  #key([x, y, z]) {
    return [x, y, z].map((value) => Math.floor(value / kCell_m)).join();
  }

  // Vertices in the box of this half size around a point.
  * near([x, y, z], half_m) {
    const steps = Math.ceil(half_m / kCell_m);
    for (let i = -steps; i <= steps; ++i) {
      for (let j = -steps; j <= steps; ++j) {
        for (let k = -steps; k <= steps; ++k) yield* this.#cells.get(this.#key([x + i * kCell_m, y + j * kCell_m, z + k * kCell_m])) ?? [];
      }
    }
  }

  // The distance to the nearest vertex, at most 0.2 m.
  distance(point) {
    let least = 0.2;
    for (const vertex of this.near(point, 0.2)) least = Math.min(least, Math.hypot(...vertex.map((value, i) => value - point[i])));
    return least;
  }

  // How far an upright axis is from what stands in the way between two heights, at most 0.2 m.
  clearance([x, y], low_m, high_m) {
    let least = 0.2;
    for (let z = low_m; z < high_m; z += kCell_m) {
      for (const vertex of this.near([x, y, z], 0.2)) {
        if (vertex[2] > low_m && vertex[2] < high_m) least = Math.min(least, Math.hypot(vertex[0] - x, vertex[1] - y));
      }
    }
    return least;
  }
}
