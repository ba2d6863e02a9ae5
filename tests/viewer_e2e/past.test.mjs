// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A look back in time at a home in which furniture was moved and people walked: in a map file, the folder of a run, a saved page.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { join } from 'node:path';
import { pathToFileURL } from 'node:url';
import { after, afterEach, before, test } from 'node:test';
import { launch, Viewer } from './browser.mjs';
import { differing_share } from './png.mjs';
import { json_of, map_folder, view, work } from './program.mjs';

const kSteps = 2000;
const map_file = join(work, 'home.panoptic');
const { objects } = json_of(map_folder, 'objects.json');
const { tracks } = json_of(map_folder, 'moving.json');
const moved = objects.filter(({ state }) => state === 'moved');
let program;
let browser;
let viewer;

before(async () => {
  browser = await launch();
});

after(() => browser.close());

afterEach(async () => {
  const errors = await viewer?.close();
  viewer = null;
  await program?.stop();
  program = null;
  assert.deepEqual(errors ?? [], []);
});

async function opened(folder, options) {
  program = view({ folder });
  viewer = await Viewer.open(browser, await program.url(), options);
  await viewer.until_state('Finished');
  return viewer.settle();
}

const bar = () => viewer.page.getByRole('group', { name: 'Look back in time' });
const slider = () => viewer.page.getByRole('slider', { name: 'Time' });
const clock = () => bar().locator('output').textContent();
const tags = () => viewer.page.locator('.tag:is(.ghost, .moving):not([hidden])').allTextContents();

// Moves the slider to the first step from that time on, and says which time that is. `end_s`: of the slider.
async function look_at(time_s, { start_s, end_s }) {
  const step = Math.ceil(kSteps * (time_s - start_s) / (end_s - start_s));
  await slider().fill(`${step}`);
  await viewer.settle();
  return start_s + (end_s - start_s) * step / kSteps;
}

const history = async () => (await viewer.page.request.get(new URL('/api/history', viewer.page.url()).href)).json();
const there_by_query = (time_s) =>
  JSON.parse(execFileSync(process.env.PANOPTIC_PROGRAM, ['query', map_file, '--when', `${time_s}`, '--json'], { encoding: 'utf8' })).length;

test('Past: the end of the slider is the map of now', async () => {
  const now = await opened(map_folder);
  assert.equal(await clock(), 'now');
  assert.deepEqual(await tags(), []);
  assert.match(await bar().locator('.note').textContent(), new RegExp(`${moved.length} moved · ${tracks.length} tracks?$`));
  assert.equal(await bar().locator('.missing').textContent(), '');
  const past = await history();
  await look_at(moved[0].gone_time - 0.2, past);
  assert.ok(differing_share(now, await viewer.look()) > 0.002, 'an earlier time looks the same');
  await slider().fill(`${kSteps}`);
  assert.equal(differing_share(now, await viewer.settle()), 0);
  assert.deepEqual(await tags(), []);
});

test('Past: a chair is where it was until it was known to be gone', async () => {
  await opened(map_folder);
  const past = await history();
  const { class: name, gone_time } = moved[0];
  const text = `${name}, moved at ${Number(gone_time.toFixed(1))} s`;
  await look_at(gone_time - 0.2, past);
  assert.ok((await tags()).includes(text), `${await tags()}`);
  await viewer.screenshot('past_ghost');
  await look_at(gone_time, past);
  assert.ok(!(await tags()).includes(text));
  await look_at(gone_time - 0.2, past);
  await viewer.page.getByRole('switch', { name: `Show ${name}` }).click();
  await viewer.settle();
  assert.ok(!(await tags()).includes(text), 'its class is hidden');
});

test('Past: who moves has a box and a way, and a map file shows as many objects as the program finds', async () => {
  await opened(map_file);
  const past = await history();
  assert.equal(past.tracks.length, tracks.length);
  const longest = tracks.reduce((a, b) => (b.frames.length > a.frames.length ? b : a));
  const middle_s = longest.frames[longest.frames.length >> 1].time_s;
  const at_s = await look_at(middle_s, past);
  const moving = tracks.filter(({ frames }) => frames[0].time_s <= at_s && frames.at(-1).time_s >= at_s);
  const names = moving.map((track) => track.class ?? 'something moves');  // one of them at least: tags never lie on each other
  assert.ok((await tags()).some((tag) => names.includes(tag)), `${await tags()}`);
  assert.equal(await bar().locator('.note').textContent(), `${there_by_query(at_s)} there · ${moving.length} moving`);
  await viewer.screenshot('past_moving');
});

test('Past: J plays from the beginning to now, in dark colours on a phone, too', async () => {
  await opened(map_file, { colorScheme: 'dark', viewport: { width: 420, height: 800 }, hasTouch: true });
  const past = await history();
  await look_at(past.end_s - 0.8, past);
  await viewer.screenshot('past_phone');
  await viewer.page.keyboard.press('j');
  assert.ok(await viewer.button('Pause').isVisible());
  await viewer.until(async () => (await clock()) === 'now', 'it never came to its end');
  assert.ok(await viewer.button('Play what happened').isVisible());
  await viewer.page.keyboard.press('j');
  assert.notEqual(await clock(), 'now');
  await viewer.page.keyboard.press('j');
});

test('Past: a saved page looks back, too', async () => {
  const folder = join(work, 'saved_page');
  execFileSync(process.env.PANOPTIC_PROGRAM, ['export-web', map_file, '-o', folder, '--camera-frames', '0']);
  viewer = await Viewer.open(browser, pathToFileURL(join(folder, 'index.html')).href);
  await viewer.until_state('Finished');
  await viewer.until(async () => await viewer.page.locator('body.playing').count() > 0, 'Play never began');  // as saved pages do
  assert.equal(await bar().isVisible(), false);
  await viewer.page.keyboard.press('g');
  await slider().fill('0');
  assert.notEqual(await clock(), 'now');
  assert.match(await bar().locator('.note').textContent(), /^\d+ there/);
});
