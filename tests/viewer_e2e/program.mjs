// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Starts the program and finds out where it serves.
import { spawn } from 'node:child_process';
import { readFileSync } from 'node:fs';
import { createServer } from 'node:net';
import { join } from 'node:path';

const kStart_ms = 60000;

export const work = process.env.PANOPTIC_WORK;
export const map_folder = join(work, 'map');
export const home_folder = join(work, 'home');

export function json_of(...parts) {
  return JSON.parse(readFileSync(join(...parts), 'utf8'));
}

export function free_port() {
  return new Promise((resolve) => {
    const server = createServer().listen(0, '127.0.0.1', () => {
      const { port } = server.address();
      server.close(() => resolve(port));
    });
  });
}

export class Program {
  output = '';
  #child;
  #ended;

  constructor(args) {
    this.#child = spawn(process.env.PANOPTIC_PROGRAM, args, { stdio: ['ignore', 'pipe', 'pipe'] });
    for (const stream of [this.#child.stdout, this.#child.stderr]) stream.on('data', (data) => { this.output += data; });
    this.#ended = new Promise((resolve) => { this.#child.on('close', (code, signal) => resolve({ code, signal })); });
  }

  // The address that it prints.
  async url() {
    const until = Date.now() + kStart_ms;
    for (;;) {
      const found = /http:\/\/[^\s/]+\/\S*/.exec(this.output);
      if (found) return found[0];
      if (Date.now() > until || this.#child.exitCode !== null) throw new Error(`the program printed no address:\n${this.output}`);
      await new Promise((resolve) => setTimeout(resolve, 30));
    }
  }

  get running() {
    return this.#child.exitCode === null && this.#child.signalCode === null;
  }

  ended() {
    return this.#ended;
  }

  // Ends the program as Ctrl-C does. Returns {code, signal}.
  stop() {
    if (this.running) this.#child.kill('SIGINT');
    return this.#ended;
  }
}

// panoptic view of the mapped home, or of another folder.
export function view({ folder = map_folder, port = 0, args = [] } = {}) {
  return new Program(['view', folder, '--port', `${port}`, ...args]);
}
