// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Figures in a map that grows: Play is opened while a run goes on, its floor is renewed beneath them, and at the end they sit.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { join } from 'node:path';
import { launch, Viewer } from './browser.mjs';
import { home_folder, json_of, Program, work } from './program.mjs';

const kJump_m = 0.3;
let browser;

before(async () => { browser = await launch(); });
after(() => browser.close());

const run = (name, args) => new Program(['run', home_folder, '--predictions', join(home_folder, 'predictions'), '--set', process.env.PANOPTIC_VOXELS,
  '-o', join(work, name), '--online', '--view', '--port', '0', ...args]);
const log_of = (viewer) => viewer.page.evaluate(() => globalThis.panoptic_play.log());

const apart = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1]);

// Play is opened before there is a floor: it says so, and begins by itself.
async function wait_for_floor(viewer) {
  const none = { revision: 0, looked_at: 1, finished: false, why_not: 'the map has no floor' };
  let asked = 0;
  await viewer.page.route('**/api/play/plan.json', (route) => (++asked <= 2 ? route.fulfill({ json: none }) : route.continue()));
  await viewer.button('Play').click();
  await viewer.page.getByText('Play begins by itself as soon as there is a floor. So far: the map has no floor').waitFor();
  await viewer.page.waitForFunction(() => globalThis.panoptic_play?.active);
  assert.ok(asked > 2, 'it began without a floor');
}

// The plan of the whole map is there: somebody goes to a seat, and sits on a true one.
async function sit(viewer) {
  await viewer.until(async () => (await log_of(viewer)).plan.finished, 'the last plan never came');
  const goes = await viewer.page.evaluate(() => {
    const { crew: { people: [{ actor }], places: { seats } } } = globalThis.panoptic_play;
    const seat = seats.find((one) => actor.sit(one));
    globalThis.panoptic_play.advance(40);
    return seat !== undefined;
  });
  assert.ok(goes, 'there is no seat to which a way leads');
  const { people: [person] } = await log_of(viewer);
  assert.equal(person.state, 'sitting');
  const { seats } = json_of(home_folder, 'affordances_truth.json');
  const off_m = Math.min(...seats.map(({ position }) => apart(position, person.world)));
  assert.ok(off_m < 0.25, `${off_m} m from the nearest true seat`);
  await viewer.page.evaluate(([x, y, z]) => {
    globalThis.panoptic_play.look([x + 1.4, 1.9, z + 1.4], [x, 0.6, z]);
    return globalThis.panoptic_play.drawn();
  }, person.place);
  await viewer.screenshot('live_play_sitting');
}

// At a fifth of the camera's speed the run takes 25 s, however fast the machine.
test('Play: while mapping goes on the floor is renewed beneath a person who stays, and at the end it sits', async (t) => {
  const program = run('live_play', ['--speed', '0.2']);
  const viewer = await Viewer.open(browser, await program.url());
  try {
    await wait_for_floor(viewer);
    assert.ok(program.running && (await viewer.state()) === 'Live', 'Play began after the run');
    await viewer.page.evaluate(() => {
      const play = globalThis.panoptic_play;
      play.clear();
      play.toggle('alone', false);
      play.add_person();
    });
    const logs = [];
    await viewer.until(async () => {
      const log = await log_of(viewer);
      if (log.people.length === 0) await viewer.page.evaluate(() => globalThis.panoptic_play.add_person());
      else logs.push(log);
      if (logs.length === 40) await viewer.screenshot('live_play');
      return (await viewer.state()) === 'Finished';
    }, 'the run never ended');
    const revisions = new Set(logs.map(({ plan }) => plan.revision));
    assert.ok(revisions.size >= 3, `plans of the revisions ${[...revisions]}`);
    const most_m = Math.max(kJump_m, logs.at(-1).plan.aside_m + 0.05);  // who is put aside farther is told of
    logs.slice(1).forEach(({ people: [{ world }] }, i) => {
      const [{ world: before_it }] = logs[i].people;
      assert.ok(apart(world, before_it) < most_m, `${before_it} became ${world}`);
    });
    t.diagnostic(JSON.stringify({ revisions: [...revisions], aside_m: logs.at(-1).plan.aside_m }));
    await sit(viewer);
  } finally {
    assert.deepEqual((await viewer.close()).filter((text) => !/ERR_/.test(text)), []);
    await program.stop();
  }
});
