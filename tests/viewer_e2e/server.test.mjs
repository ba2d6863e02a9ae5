// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The page and the server over time: restarts, tokens, several browsers, a map that grows.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { join } from 'node:path';
import { launch, Viewer } from './browser.mjs';
import { share_of_color } from './png.mjs';
import { free_port, home_folder, json_of, map_folder, Program, view, work } from './program.mjs';

const kLightScene = [0xe3, 0xe8, 0xed];
const kUnreachable = /ERR_CONNECTION_REFUSED|ERR_CONNECTION_RESET|ERR_EMPTY_RESPONSE|ERR_INCOMPLETE_CHUNKED_ENCODING/;
const triangles = json_of(map_folder, 'report.json').mesh.triangles;
let browser;

before(async () => { browser = await launch(); });
after(() => browser.close());

const unexpected = (errors) => errors.filter((text) => !kUnreachable.test(text));

test('Server: the page comes back by itself after a restart', async () => {
  const port = await free_port();
  let program = view({ port });
  const viewer = await Viewer.open(browser, await program.url());
  try {
    await viewer.settle();
    await program.stop();
    await viewer.until_state('Reconnecting');
    assert.ok((await viewer.counts()).triangles > 0, 'what was there is gone');
    await viewer.screenshot('reconnecting');
    program = view({ port });
    await viewer.until_state('Finished');
    const picture = await viewer.settle();
    assert.equal((await viewer.counts()).triangles, triangles);
    assert.ok(share_of_color(picture, kLightScene) < 0.7);
  } finally {
    assert.deepEqual(unexpected(await viewer.close()), []);
    await program.stop();
  }
});

test('Server: two browsers look at once, each as it likes', async () => {
  const program = view();
  const other = await launch();
  const url = await program.url();
  const [one, two] = await Promise.all([Viewer.open(browser, url), Viewer.open(other, url, { colorScheme: 'dark' })]);
  try {
    await one.mode('Class').click();
    await Promise.all([one.settle(), two.settle()]);
    assert.equal((await one.counts()).triangles, triangles);
    assert.equal((await two.counts()).triangles, triangles);
    assert.equal(await two.mode('Colour').getAttribute('aria-checked'), 'true');
  } finally {
    assert.deepEqual([...await one.close(), ...await two.close()], []);
    await other.close();
    await program.stop();
  }
});

test('Server: shows nothing without its token, and with it the address forgets it', async () => {
  const program = view({ args: ['--token', 'rather-secret'] });
  const { origin } = new URL(await program.url());
  const page = await browser.newPage();
  try {
    const refused = await page.goto(`${origin}/`);
    assert.equal(refused.status(), 401);
    assert.match(await page.textContent('body'), /token/);
    const guest = await Viewer.open(browser, `${origin}/?token=rather-secret`);
    await guest.settle();
    assert.equal(guest.page.url(), `${origin}/`);
    await guest.page.reload();
    await guest.settle();
    assert.deepEqual(await guest.close(), []);
  } finally {
    await page.close();
    await program.stop();
  }
});

test('Server: a page whose token is no longer good says so', async () => {
  const port = await free_port();
  let program = view({ port, args: ['--token', 'the-first-secret'] });
  const viewer = await Viewer.open(browser, await program.url());
  try {
    await viewer.settle();
    await program.stop();
    program = view({ port, args: ['--token', 'another-secret'] });
    await viewer.until_state('Token needed');
  } finally {
    await viewer.close();
    await program.stop();
  }
});

function run_with_view(name, args = []) {
  return new Program(['run', home_folder, '--predictions', join(home_folder, 'predictions'), '--set', process.env.PANOPTIC_VOXELS,
    '-o', join(work, name), '--view', '--port', '0', ...args]);
}

// At a fifth of the camera's speed the run takes 15 s, however fast the machine.
test('Server: the surface grows while mapping runs', async () => {
  const program = run_with_view('live_online', ['--online', '--speed', '0.2']);
  const viewer = await Viewer.open(browser, await program.url());
  try {
    const seen = new Set();
    while (program.running && (await viewer.state()) !== 'Finished') {
      const { triangles: shown } = await viewer.counts();
      if (shown > 0 && (await viewer.state()) === 'Live') seen.add(shown);
      if (seen.size === 2) await viewer.screenshot('live');
      await viewer.page.waitForTimeout(50);
    }
    const numbers = [...seen];
    assert.ok(numbers.length >= 2 && numbers[0] < numbers.at(-1), `the page showed ${numbers} triangles`);
  } finally {
    assert.deepEqual(unexpected(await viewer.close()), []);
    await program.stop();
  }
});

test('Server: a watched run ends with the whole surface, and with the map of an unwatched one', async () => {
  const program = run_with_view('live');
  const viewer = await Viewer.open(browser, await program.url());
  try {
    await viewer.until_state('Finished');
    await viewer.settle();
    assert.equal((await viewer.counts()).triangles, triangles);
    await program.stop();
    assert.equal(json_of(work, 'live', 'report.json').map_hash, json_of(map_folder, 'report.json').map_hash);
  } finally {
    assert.deepEqual(unexpected(await viewer.close()), []);
    await program.stop();
  }
});
