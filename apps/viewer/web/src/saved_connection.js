// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// In place of connection.js in a saved page (panoptic export-web): everything is there from the beginning, and stays as it is.
import { parse_chunks } from './protocol.js';
import { saved_answer } from './server.js';

export class SavedConnection {
  waiting = 0;
  #listener;

  constructor(listener) {
    this.#listener = listener;
  }

  async open() {
    this.#listener.scene(await saved_answer('/api/scene').json());
    this.#listener.state(await saved_answer('/api/state').json());
    this.#listener.status('finished');
    this.#listener.objects((await saved_answer('/api/objects').json()).objects);
    let answer = null;
    for (let i = 0; (answer = saved_answer(`/api/chunks?part=${i}`)) !== null; ++i) this.#listener.chunks(parse_chunks(await answer.arrayBuffer()));
  }
}
