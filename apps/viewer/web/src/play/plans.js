// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The plans of a map: the one of a finished map, or those of a map that grows, always the newest.
import { fetch_newest, fetch_plan } from './play_data.js';

export class Plans {
  revision = 0;      // of the plan that was given last
  looked_at = 0;     // the newest snapshot that the server has planned from
  finished = false;  // no newer one will come
  why_not = '';      // why there is no plan of that
  #grows;

  constructor(grows) {
    this.#grows = grows;
  }

  get grows() {
    return this.#grows;
  }

  // Null if there is none, or none that is newer than the last one.
  async next() {
    if (!this.#grows) return fetch_plan();
    const { revision, looked_at, finished, why_not } = await fetch_newest();
    const plan = revision === this.revision ? null : await fetch_plan(`?r=${revision}`);
    Object.assign(this, { revision, looked_at, finished, why_not });
    return plan;
  }
}
