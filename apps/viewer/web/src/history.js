// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Values over the last minutes, each with its time, forgotten when too old or too many.

export class History {
  #span_s;
  #most;
  #series = new Map();

  constructor(span_s = 180, most = 900) {
    this.#span_s = span_s;
    this.#most = most;
  }

  clear() {
    this.#series.clear();
  }

  add(name, time_s, value) {
    if (!Number.isFinite(value)) return;
    const points = this.#series.get(name) ?? [];
    this.#series.set(name, points);
    points.push([time_s, value]);
    while (points.length > this.#most || points[0][0] < time_s - this.#span_s) points.shift();
  }

  points(name) {
    return this.#series.get(name) ?? [];
  }
}
