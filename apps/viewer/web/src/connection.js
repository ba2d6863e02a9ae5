// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Keeps the page's copy equal to the server's newest snapshot: listens for events, asks what changed, fetches what is lacking, and
// starts over when the server went away. A slow page skips snapshots; it never asks for the same thing twice at once.
import { parse_chunks } from './protocol.js';

const kChunksPerRequest = 64;  // the server's limit
const kRequestsAtOnce = 3;
const kObjectsEvery_ms = 800;
const kQuiet_ms = 10000;       // without an event for this long, look whether the server is still there
const kTimeout_ms = 20000;
const kBackOff_ms = [300, 700, 1500, 3000, 6000];

const pause = (ms) => new Promise((resolve) => setTimeout(resolve, ms));

class Refused extends Error {}

async function request(path) {
  const answer = await fetch(path, { signal: AbortSignal.timeout(kTimeout_ms), cache: 'no-store' });
  if (answer.status === 401 || answer.status === 403) throw new Refused('the server wants a token');
  if (!answer.ok) throw new Error(`${path}: ${answer.status}`);
  return answer;
}

// listener: {status(state), scene(scene), state(state), objects(objects), chunks(chunks)}; scene() means: forget everything.
// States: connecting, live, finished, reconnecting, refused.
export class Connection {
  #listener;
  #run = null;
  #revision = 0;
  #objects_revision = -1;
  #in_flight = 0;
  #wanted = new Map();  // chunk key -> the oldest version that will do
  #running = new Set();  // loops that are at work, so that none runs twice
  #again = new Set();
  #session = 0;  // rises with every attempt; what belongs to an older one is dropped
  #attempts = 0;
  #events = null;
  #heard_ms = 0;
  #finished = false;

  constructor(listener) {
    this.#listener = listener;
    setInterval(() => this.#look_whether_alive(), kQuiet_ms / 2);
    window.addEventListener('online', () => this.#fail(this.#session));
    document.addEventListener('visibilitychange', () => this.#on_news());
  }

  // Chunks that are to come.
  get waiting() {
    return this.#wanted.size + this.#in_flight;
  }

  async open() {
    const session = ++this.#session;
    try {
      const scene = await (await request('/api/scene')).json();
      if (session !== this.#session) return;
      if (scene.run !== this.#run) this.#start_anew(scene);
      this.#listen(session);
      this.#once('state', session, () => this.#fetch_state(session));
    } catch (error) {
      this.#fail(session, error);
    }
  }

  #start_anew(scene) {
    this.#run = scene.run;
    this.#revision = 0;
    this.#objects_revision = -1;
    this.#finished = false;
    this.#wanted.clear();
    this.#listener.scene(scene);
  }

  #listen(session) {
    this.#events = new EventSource('/events');
    this.#events.addEventListener('state', () => {
      if (session !== this.#session) return;
      this.#heard_ms = performance.now();
      this.#on_news();
    });
    // The browser would try again by itself after some errors but not after others: one rule for all of them is ours.
    this.#events.addEventListener('error', () => this.#fail(session));
  }

  async #fail(session, error) {
    if (session !== this.#session) return;
    const next = ++this.#session;
    this.#events?.close();
    this.#events = null;
    this.#running.clear();
    this.#again.clear();
    this.#listener.status(error instanceof Refused ? 'refused' : this.#run === null ? 'connecting' : 'reconnecting');
    await pause(kBackOff_ms[Math.min(this.#attempts++, kBackOff_ms.length - 1)]);
    if (next === this.#session) this.open();
  }

  #look_whether_alive() {
    if (performance.now() - this.#heard_ms >= kQuiet_ms) this.#on_news();
  }

  // A page that nobody sees asks for nothing; it catches up when it is seen again.
  #on_news() {
    if (this.#events === null || document.hidden) return;
    const session = this.#session;
    this.#once('state', session, () => this.#fetch_state(session));
  }

  // Runs `work` now, or once more after the one that is under way.
  async #once(name, session, work) {
    if (this.#running.has(name)) {
      this.#again.add(name);
      return;
    }
    this.#running.add(name);
    try {
      do {
        this.#again.delete(name);
        await work();
      } while (session === this.#session && this.#again.has(name));
    } catch (error) {
      this.#fail(session, error);
    } finally {
      if (session === this.#session) this.#running.delete(name);
    }
  }

  async #fetch_state(session) {
    const state = await (await request(`/api/state?since=${this.#revision}`)).json();
    if (session !== this.#session) return;
    this.#attempts = 0;
    this.#heard_ms = performance.now();
    this.#revision = state.revision;
    this.#finished = state.run.finished;
    for (const [key, version] of state.chunks) this.#wanted.set(key, version);
    this.#listener.status(this.#finished ? 'finished' : 'live');
    this.#listener.state(state);
    for (let i = 0; i < kRequestsAtOnce; ++i) this.#once(`chunks${i}`, session, () => this.#fetch_chunks(session));
    if (this.#objects_revision !== state.revision) this.#once('objects', session, () => this.#fetch_objects(session));
  }

  async #fetch_objects(session) {
    const answer = await (await request('/api/objects')).json();
    if (session !== this.#session) return;
    this.#objects_revision = answer.revision;
    this.#listener.objects(answer.objects);
    await pause(kObjectsEvery_ms);  // names change slowly; the list is sent whole
  }

  async #fetch_chunks(session) {
    const run = this.#run;  // what was asked for in it stays good when only the connection breaks
    while (this.#wanted.size > 0 && session === this.#session) {
      const batch = [...this.#wanted].slice(0, kChunksPerRequest);
      for (const [key] of batch) this.#wanted.delete(key);  // so that the other loops take other ones
      try {
        const chunks = await this.#fetch_batch(batch.map(([key]) => key));
        if (run === this.#run) this.#listener.chunks(chunks);
      } catch (error) {
        for (const [key, version] of run === this.#run ? batch : []) if (!this.#wanted.has(key)) this.#wanted.set(key, version);
        throw error;
      }
    }
  }

  async #fetch_batch(keys) {
    this.#in_flight += keys.length;
    try {
      return parse_chunks(await (await request(`/api/chunks?k=${keys.join(',')}`)).arrayBuffer());
    } finally {
      this.#in_flight -= keys.length;
    }
  }
}
