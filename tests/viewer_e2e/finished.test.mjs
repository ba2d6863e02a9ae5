// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// `panoptic view OUT`: a finished map in the browser.
import assert from 'node:assert/strict';
import { after, afterEach, before, test } from 'node:test';
import { readFile } from 'node:fs/promises';
import { launch, Viewer } from './browser.mjs';
import { differing_share, share_of_color } from './png.mjs';
import { json_of, map_folder, view } from './program.mjs';

const kLightScene = [0xe3, 0xe8, 0xed];
const kDarkScene = [0x12, 0x17, 0x1d];
const objects = json_of(map_folder, 'objects.json').objects;
const report = json_of(map_folder, 'report.json');
let program;
let url;
let browser;
let viewer;

before(async () => {
  program = view();
  browser = await launch();
  url = await program.url();
});

after(async () => {
  await browser.close();
  assert.equal((await program.stop()).signal, null, program.output);
});

afterEach(async () => {
  const errors = await viewer?.close();
  viewer = null;
  assert.deepEqual(errors ?? [], []);
});

async function opened(options) {
  viewer = await Viewer.open(browser, url, options);
  await viewer.until_state('Finished');
  return viewer.settle();
}

async function choose_largest() {
  await viewer.page.getByRole('tab', { name: /Objects/ }).click();
  const name = await viewer.page.locator('#objects li .name').first().textContent();
  await viewer.page.locator('#objects li button').first().click();
  return objects.find((object) => `${object.class.replaceAll(' ', '_')}_${object.id}` === name);
}

test('Page: shows every triangle of a finished map', async () => {
  const picture = await opened();
  assert.equal((await viewer.counts()).triangles, report.mesh.triangles);
  assert.ok(share_of_color(picture, kLightScene) < 0.7, 'the canvas is empty');
  assert.equal(await viewer.page.locator('#object-count').textContent(), `${objects.length}`);
  assert.match(await viewer.page.title(), /PanopticFusion/);
  await viewer.screenshot('light');
});

test('Page: each mode shows the surface differently', async () => {
  let picture = await opened();
  for (const mode of ['Class', 'Panoptic', 'Normals', 'Colour']) {
    await viewer.mode(mode).click();
    const next = await viewer.look_after_change(picture);
    assert.ok(differing_share(picture, next) > 0.1, `${mode} changes hardly a pixel`);
    assert.equal(await viewer.mode(mode).getAttribute('aria-checked'), 'true');
    picture = next;
    await viewer.screenshot(`mode_${mode.toLowerCase()}`);
  }
  assert.ok(await viewer.mode('Confidence').isDisabled(), 'a finished result has no confidence to show');
});

test('Page: a class that is switched off leaves the picture, and comes back', async () => {
  const whole = await opened();
  const wall = viewer.page.getByRole('switch', { name: 'Show wall' });
  await wall.click();
  const without = await viewer.look_after_change(whole);
  assert.ok(share_of_color(without, kLightScene) > share_of_color(whole, kLightScene) + 0.02);
  assert.equal(await wall.getAttribute('aria-checked'), 'false');
  await viewer.button('None').click();
  const nothing = await viewer.look_after_change(without);
  assert.ok(share_of_color(nothing, kLightScene) > 0.97);
  await viewer.button('All').click();
  assert.equal(differing_share(whole, await viewer.look_after_change(nothing)), 0);
});

test('Page: an object of the list is shown with everything that is known about it', async () => {
  await opened();
  const object = await choose_largest();
  const details = viewer.page.getByRole('region', { name: 'Selected object' });
  const facts = await details.locator('.facts').textContent();
  assert.equal(await details.locator('#selected-class').textContent(), `class ${object.class}`);
  assert.equal(await details.locator('.bars .name').first().textContent(), object.class);
  assert.ok(facts.includes(`Observations${object.observations.toLocaleString('en')}`), facts);
  assert.ok(facts.includes(`Seen in frames${object.first_frame} to ${object.last_frame}`), facts);
  const size = [0, 1, 2].map((k) => (object.box.max_m[k] - object.box.min_m[k]).toFixed(2)).join(' × ');
  assert.ok(facts.includes(`Size${size} m`), facts);
  await viewer.settle();
  await viewer.screenshot('object');
});

test('Page: a click on an object in the scene shows its class', async () => {
  await opened();
  const object = await choose_largest();
  await viewer.settle();
  const name = await viewer.page.locator('#selected-name').textContent();
  await viewer.button('Clear the selection').click();
  const box = await viewer.page.locator('#surface').boundingBox();
  let found = '';
  for (let i = 0; i < 24 && found !== name; ++i) {  // the middle of a box need not be surface: outwards in a spiral
    const [turn, radius] = [2.4 * i, 14 * Math.sqrt(i)];
    await viewer.page.mouse.click(box.x + box.width / 2 + radius * Math.cos(turn), box.y + box.height / 2 + radius * Math.sin(turn));
    found = (await viewer.page.locator('#selected-name').count()) > 0 ? await viewer.page.locator('#selected-name').textContent() : '';
  }
  assert.equal(found, name);
  assert.equal(await viewer.page.locator('#selected-class').textContent(), `class ${object.class}`);
  await viewer.screenshot('picked');
});

test('Page: the list finds objects by name and sorts them', async () => {
  await opened();
  await viewer.page.keyboard.press('/');
  await viewer.page.keyboard.type(objects[0].class);
  const names = viewer.page.locator('#objects li .name');
  const wanted = objects.filter((object) => object.class.includes(objects[0].class)).length;
  await viewer.until(async () => (await names.count()) === wanted, 'the search finds other objects');
  await viewer.page.getByLabel('Search objects').fill('');
  await viewer.page.getByLabel('Sort objects').selectOption('Name');
  const sorted = await names.allTextContents();
  assert.equal(sorted.length, objects.length);
  assert.deepEqual(sorted, [...sorted].sort((a, b) => a.localeCompare(b, 'en', { numeric: true })));
});

test('Page: follows the colours of the system until somebody chooses', async () => {
  const dark = await opened({ colorScheme: 'dark' });
  assert.ok(share_of_color(dark, kDarkScene) > 0.05);
  await viewer.screenshot('dark');
  await viewer.page.emulateMedia({ colorScheme: 'light' });
  const light = await viewer.look_after_change(dark);
  assert.ok(share_of_color(light, kLightScene) > 0.05);
  await viewer.page.keyboard.press('t');
  assert.ok(share_of_color(await viewer.look_after_change(light), kDarkScene) > 0.05);
  await viewer.page.reload();
  assert.ok(share_of_color(await viewer.settle(), kDarkScene) > 0.05, 'the choice is forgotten');
});

test('Page: keys move, show the help and reset the view', async () => {
  const start = await opened();
  await viewer.page.keyboard.press('f');
  await viewer.page.keyboard.down('w');
  await viewer.until(async () => differing_share(start, await viewer.look()) > 0.02, 'W does not walk');
  await viewer.page.keyboard.up('w');
  await viewer.page.locator('#notice').waitFor({ state: 'hidden' });
  const walked = await viewer.settle();
  await viewer.page.keyboard.press('r');
  assert.ok(differing_share(start, await viewer.look_after_change(walked)) < 0.02);
  await viewer.page.keyboard.press('?');
  assert.ok(await viewer.page.getByRole('dialog', { name: 'Keyboard shortcuts' }).isVisible());
  await viewer.screenshot('help');
});

test('Page: hands out a picture and the surface as files', async () => {
  await opened();
  for (const [name, magic, suffix] of [['Save a screenshot', '\x89PNG', '.png'], ['Download the surface as GLB', 'glTF', '.glb']]) {
    const [download] = await Promise.all([viewer.page.waitForEvent('download'), viewer.button(name).click()]);
    assert.ok(download.suggestedFilename().endsWith(suffix), download.suggestedFilename());
    const bytes = await readFile(await download.path());
    assert.equal(bytes.toString('latin1', 0, 4), magic);
    assert.ok(bytes.length > 10000);
  }
});

test('Page: panels are widened with the keyboard and stay so', async () => {
  await opened();
  const width = async () => (await viewer.page.locator('#left').boundingBox()).width;
  const before_px = await width();
  await viewer.page.getByRole('separator', { name: 'Width of the lists' }).focus();
  await viewer.page.keyboard.press('ArrowRight');
  assert.ok((await width()) > before_px);
  const widened_px = await width();
  await viewer.page.reload();
  await viewer.settle();
  assert.equal(await width(), widened_px);
});

test('Page: on a tablet the panels are drawers', async () => {
  await opened({ viewport: { width: 820, height: 1100 }, hasTouch: true });
  assert.ok(!(await viewer.page.locator('#left').isVisible()));
  await viewer.button('Show or hide classes and objects').click();
  await viewer.page.getByRole('switch', { name: 'Show wall' }).waitFor();
  await viewer.screenshot('tablet');
});
