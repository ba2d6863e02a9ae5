// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The connection against a server of this test's own that can be cut, restarted and made to answer late.
import assert from 'node:assert/strict';
import { afterEach, beforeEach, test } from 'node:test';
import { Connection } from '../src/connection.js';

const kEmptyList = Uint8Array.from([0x50, 0x46, 0x43, 0x32, 0, 0, 0, 0]);  // "PFC2", no chunks
let server;
let heard;
let connection;

class FakeEvents extends EventTarget {
  static open = [];
  constructor() {
    super();
    FakeEvents.open.push(this);
  }

  close() {
    FakeEvents.open = FakeEvents.open.filter((other) => other !== this);
  }
}

function answer_to(path) {
  server.asked.push(path);
  if (server.down) throw new TypeError('refused');
  if (server.status !== 200) return new Response('no', { status: server.status });
  if (path === '/api/scene') return Response.json({ run: server.run });
  if (path === '/api/objects') return Response.json({ revision: server.revision, objects: [] });
  if (path.startsWith('/api/chunks')) return new Response(kEmptyList);
  const since = Number(/since=(\d+)/.exec(path)[1]);
  return Response.json({ revision: server.revision, chunks: server.chunks.filter(([, version]) => version > since), run: { finished: false } });
}

const tell = () => { for (const events of FakeEvents.open) events.dispatchEvent(new Event('state')); };
const cut = () => { for (const events of [...FakeEvents.open]) events.dispatchEvent(new Event('error')); };
const asked = (start) => server.asked.filter((path) => path.startsWith(start));

async function until(holds) {
  for (let i = 0; i < 300 && !holds(); ++i) await new Promise((resolve) => setTimeout(resolve, 10));
  assert.ok(holds(), `${holds}: ${JSON.stringify({ heard, asked: server.asked })}`);
}

beforeEach(async () => {
  server = { run: 'one', revision: 5, chunks: [['0,0,0', 3], ['1,0,0', 5]], asked: [], down: false, status: 200 };
  heard = { status: [], scene: [], state: [] };
  FakeEvents.open = [];
  globalThis.EventSource = FakeEvents;
  globalThis.document = Object.assign(new EventTarget(), { hidden: false });
  globalThis.window = new EventTarget();
  globalThis.fetch = async (path) => answer_to(path);
  globalThis.setInterval = () => 0;  // the look-out would keep the test alive
  const note = (name) => (value) => { heard[name].push(value); };
  connection = new Connection({ status: note('status'), scene: note('scene'), state: note('state'), objects: () => {}, chunks: () => {} });
  await connection.open();
  await until(() => heard.state.length === 1 && connection.waiting === 0);
});

afterEach(() => { server.down = true; });

test('Connection: fetches what it lacks, all of it in one request', () => {
  assert.deepEqual(asked('/api/chunks'), ['/api/chunks?k=0,0,0,1,0,0']);
  assert.deepEqual(heard.status, ['live']);
});

test('Connection: asks only for what is newer than it has', async () => {
  server.revision = 6;
  server.chunks[0][1] = 6;
  tell();
  await until(() => asked('/api/chunks').length === 2);
  assert.equal(asked('/api/state').at(-1), '/api/state?since=5');
  assert.equal(asked('/api/chunks').at(-1), '/api/chunks?k=0,0,0');
});

test('Connection: many events at once become few questions', async () => {
  for (let i = 0; i < 50; ++i) tell();
  await until(() => heard.state.length >= 2);
  await new Promise((resolve) => setTimeout(resolve, 50));
  assert.ok(heard.state.length <= 3, `${heard.state.length}`);
});

test('Connection: comes back after a cut without starting over', async () => {
  cut();
  await until(() => heard.status.includes('reconnecting'));
  await until(() => heard.status.at(-1) === 'live');
  assert.equal(heard.scene.length, 1);
  assert.equal(asked('/api/state').at(-1), '/api/state?since=5');
  assert.equal(FakeEvents.open.length, 1);
});

test('Connection: another run means starting anew', async () => {
  server.run = 'two';
  server.revision = 2;
  cut();
  await until(() => heard.scene.length === 2 && heard.status.at(-1) === 'live');
  assert.equal(asked('/api/state').at(-1), '/api/state?since=0');
});

test('Connection: chunks that were lost with the connection are asked for again', async () => {
  server.revision = 7;
  server.chunks[1][1] = 7;
  const answer = globalThis.fetch;
  globalThis.fetch = async (path) => {
    if (path.startsWith('/api/chunks')) throw new TypeError('cut');
    return answer(path);
  };
  tell();
  await until(() => heard.status.includes('reconnecting'));
  assert.equal(connection.waiting, 1);
  globalThis.fetch = answer;
  await until(() => connection.waiting === 0);
  assert.equal(asked('/api/chunks').at(-1), '/api/chunks?k=1,0,0');
});

test('Connection: says that a token is needed, and goes on trying', async () => {
  server.status = 401;
  cut();
  await until(() => heard.status.includes('refused'));
  server.status = 200;
  await until(() => heard.status.at(-1) === 'live');
});

test('Connection: a page that nobody sees asks for nothing', async () => {
  globalThis.document.hidden = true;
  const before = server.asked.length;
  tell();
  await new Promise((resolve) => setTimeout(resolve, 50));
  assert.equal(server.asked.length, before);
  globalThis.document.hidden = false;
  globalThis.document.dispatchEvent(new Event('visibilitychange'));
  await until(() => heard.state.length === 2);
});
