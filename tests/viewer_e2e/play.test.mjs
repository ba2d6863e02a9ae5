// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Figures in the map of a simulated home, against its truth: they walk, sit and lie where one can, and are hidden by what is before them.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { after, before, test } from 'node:test';
import { join } from 'node:path';
import { pathToFileURL } from 'node:url';
import { launch, Viewer } from './browser.mjs';
import { decode_png, differing_share } from './png.mjs';
import { json_of, home_folder, map_folder, Program, work } from './program.mjs';
import { Truth } from './truth.mjs';

const map_file = join(work, 'home.panoptic');
const truth = new Truth(home_folder);
const true_places = json_of(home_folder, 'affordances_truth.json');
let browser;
let program;
let viewer;
let to_world;  // from [x, y, z] of a figure

const kEvery_px = 17;

const apart = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1]);
const turn_between = (a, b) => Math.abs(Math.atan2(a[0] * b[1] - a[1] * b[0], a[0] * b[0] + a[1] * b[1]));
const log = () => viewer.page.evaluate(() => globalThis.panoptic_play.log());
// Time goes faster; everything else is as always.
const advance = (seconds) => viewer.page.evaluate((s) => globalThis.panoptic_play.advance(s), seconds);

async function open(url, options = {}) {
  const opened = await Viewer.open(browser, url, options);
  await opened.page.waitForFunction(() => globalThis.panoptic_play?.active);
  await opened.page.evaluate(() => { globalThis.panoptic_play.clear(); globalThis.panoptic_play.toggle('alone', false); });
  return opened;
}

function run(...args) {
  const { status, stderr } = spawnSync(process.env.PANOPTIC_PROGRAM, args, { encoding: 'utf8' });
  assert.equal(status, 0, stderr);
}

// Looks at a place from aside and above, so that it is in the middle of the canvas: its pixel on the page.
async function middle_of([x, y, z], of = viewer) {
  await of.page.evaluate(([at, eye]) => globalThis.panoptic_play.look(eye, at), [[x, y, z], [x + 0.5, y + 1.3, z + 0.5]]);
  await of.page.evaluate(() => globalThis.panoptic_play.drawn());
  const box = await of.page.locator('#surface').boundingBox();
  return [box.x + box.width / 2, box.y + box.height / 2];
}

async function click_at(place) {
  await viewer.page.mouse.click(...await middle_of(place));
}

before(async () => {
  browser = await launch();
  program = new Program(['play', map_file, '--port', '0']);
  viewer = await open(await program.url());
  const rows = await viewer.page.evaluate(async () => (await (await fetch('/api/play/affordances.json')).json()).world_from_grid);
  to_world = ([x, y, z]) => rows.slice(0, 3).map(([a, b, c, d]) => a * x - b * z + c * y + d);
});
after(async () => {
  assert.deepEqual(await viewer.close(), []);
  await browser.close();
  await program.stop();
});

test('Play: a person walks to the seat that was clicked and sits on it as on the true one', async () => {
  const seat = await viewer.page.evaluate(() => {
    const play = globalThis.panoptic_play;
    play.add_person();
    const [{ actor }] = play.crew.people;
    return play.crew.places.seats.find((one) => { const goes = actor.sit(one); return goes; });
  });
  assert.ok(seat, 'there is no seat to which a way leads');
  await viewer.page.evaluate(() => { globalThis.panoptic_play.clear(); globalThis.panoptic_play.add_person(); });
  await click_at(seat.at);
  await advance(40);
  const [person] = (await log()).people;
  assert.equal(person.state, 'sitting');
  const pelvis = to_world(person.pelvis);
  const nearest = true_places.seats.reduce((a, b) => (apart(a.position, pelvis) < apart(b.position, pelvis) ? a : b));
  assert.ok(apart(nearest.position, pelvis) < 0.25, `${apart(nearest.position, pelvis)} m from the true seat`);
  assert.ok(pelvis[2] > nearest.height_m && pelvis[2] < nearest.height_m + 0.2);
  const ahead = to_world([Math.sin(person.heading), 0, Math.cos(person.heading)]).map((value, i) => value - to_world([0, 0, 0])[i]);
  const off_deg = (turn_between(ahead, nearest.facing) * 180) / Math.PI;
  assert.ok(off_deg < 20, `${off_deg} degrees from where the seat faces`);
  for (const ankle of person.ankles) assert.ok(Math.abs(to_world(ankle)[2] - person.ankle_m) < 0.03, 'its soles are on the floor');
  await viewer.screenshot('play_sitting');
});

test('Play: five people of their own never walk through what is truly there, in ten minutes', async () => {
  await viewer.page.evaluate(() => {
    const play = globalThis.panoptic_play;
    play.clear();
    for (let i = 0; i < 5; ++i) play.add_person();
    for (let i = 0; i < 3; ++i) play.add_insect();
    play.toggle('alone', true);
  });
  const logs = await viewer.page.evaluate(() => {
    const { crew } = globalThis.panoptic_play;
    const kept = [];
    for (let i = 0; i < 4 * 600; ++i) {
      crew.update(0.25);
      kept.push(crew.people.map(({ actor }) => ({ state: actor.state, place: [...actor.place] })));
    }
    globalThis.panoptic_play.toggle('alone', false);
    return kept;
  });
  const seen = new Map();
  let walked_m = 0;
  logs.forEach((people, i) => people.forEach(({ state, place }, k) => {
    seen.set(state, (seen.get(state) ?? 0) + 1);
    if (state !== 'standing' && state !== 'walking') return;
    const at = to_world(place);
    assert.ok(Math.abs(at[2]) < 0.03, `${at[2]} m above the floor`);
    assert.ok(truth.clearance(at, 0.12, 1.4) > 0.1, `${at} is within furniture or a wall`);
    if (i > 0 && logs[i - 1][k].state === 'walking') walked_m += apart(at, to_world(logs[i - 1][k].place));
  }));
  assert.ok(walked_m > 100 && seen.get('sitting') > 0, `${walked_m} m walked, ${[...seen]}`);
});

// The map has walls where the truth has none to compare with (nobody saw them from near), and its voxels are 4 cm large.
test('Play: insects are within 2 cm of the true walls nine times in ten, and never a voxel and a half away', async () => {
  await viewer.page.evaluate(() => { globalThis.panoptic_play.clear(); for (let i = 0; i < 3; ++i) globalThis.panoptic_play.add_insect(); });
  const distances = [];
  for (let i = 0; i < 40; ++i) {
    await advance(2);
    for (const place of (await log()).insects) distances.push(truth.distance(to_world(place)));
  }
  distances.sort((a, b) => a - b);
  assert.equal(distances.length, 120);
  assert.ok(distances[108] < 0.02 && distances[119] < 0.06, `${distances.slice(100)} m`);
});

test('Play: what is put on a table rests on it, and falls when it is pushed over the edge', async () => {
  const table = await viewer.page.evaluate(() => {
    globalThis.panoptic_play.clear();
    const free = globalThis.panoptic_play.crew.places.tables.find((top) => top.free.length > 0)?.free[0];
    return free ? [0, 1, 2].map((k) => free.reduce((sum, corner) => sum + corner[k] / free.length, 0)) : null;
  });
  assert.ok(table, 'no table top was found');
  await viewer.button('Teapot').click();
  await click_at(table);
  await viewer.until(async () => (await log()).things.length === 1, 'nothing was put there');
  await advance(3);
  const [{ place, turn }] = (await log()).things;
  assert.ok(truth.distance(to_world(place)) < 0.02 && Math.abs(place[1] - table[1]) < 0.03, `it is at ${place}`);
  assert.ok(Math.abs(turn[0]) < 0.05 && Math.abs(turn[2]) < 0.05, 'it stands upright');
  await viewer.screenshot('play_table');
  const has_fallen = ({ place: [, y] }) => y < table[1] - 0.1;
  let [fallen] = (await log()).things;
  for (let i = 0; i < 64 && !has_fallen(fallen); ++i) {
    const angle = Math.floor(i / 8) * 3 * Math.PI / 4;  // each of eight directions: walls may be on some sides
    const speed = [1.5 * Math.cos(angle), 0.8, 1.5 * Math.sin(angle)];  // hops over what else lies there
    await viewer.page.evaluate((v) => globalThis.panoptic_play.push(0, v), speed);
    await advance(1);
    [fallen] = (await log()).things;
  }
  await advance(2);
  [fallen] = (await log()).things;
  assert.ok(fallen && has_fallen(fallen) && fallen.place[1] > -0.05, `it is at ${fallen?.place}`);
});

test('Distances: a slice lies in the map at the height of the slider, and goes again', async () => {
  const guest = await Viewer.open(browser, (await program.url()).replace('#play', ''));
  try {
    const panel = guest.page.locator('#distances');
    const before = await guest.settle();
    await guest.button('Distances to the nearest surface').click();
    await panel.waitFor({ state: 'visible' });
    const low = await guest.look_after_change(before);
    const height_m = async () => Number.parseFloat(await panel.locator('output').textContent());
    assert.ok(Math.abs(await height_m() - 0.5) < 0.05, `${await height_m()}`);
    await guest.screenshot('distances');
    await panel.locator('input').evaluate((slider) => { slider.value = `${Number(slider.value) + 15}`; slider.dispatchEvent(new Event('input')); });
    await guest.look_after_change(low);
    assert.ok(await height_m() > 1, `${await height_m()}`);
    await guest.page.keyboard.press('m');
    assert.equal(await panel.isHidden(), true);
    assert.ok(differing_share(before, await guest.settle()) < 0.02, 'something stayed');
  } finally {
    assert.deepEqual(await guest.close(), []);
  }
});

test('Play: ways in the browser are those of the program', async () => {
  const ways = await viewer.page.evaluate(() => {
    const { floor } = globalThis.panoptic_play.crew;
    const found = [];
    for (let i = 0; i < 400 && found.length < 3; ++i) {
      const [from, to] = [floor.random(), floor.random()];
      const way = floor.way(from, to);
      if (way && Math.hypot(to[0] - from[0], to[2] - from[2]) > 1) found.push(way);
    }
    return found;
  });
  assert.equal(ways.length, 3);
  for (const [i, way] of ways.entries()) {
    const ends = [way[0], way.at(-1)].map((point) => to_world(point).join());
    const folder = join(work, `plan${i}`);
    run('plan', map_file, '-o', folder, `--from=${ends[0]}`, `--to=${ends[1]}`);
    const { found, points } = json_of(folder, 'path.json');
    assert.ok(found);
    const length = (corners) => corners.slice(1).reduce((sum, point, k) => sum + apart(point, corners[k]), 0);
    const here = way.map(([x, , z]) => [x, -z]);
    assert.ok(Math.abs(length(here) - length(points)) < 0.01, `${length(here)} m and ${length(points)} m`);
    for (const corner of here) assert.ok(Math.min(...points.map((point) => apart(point, corner))) < 0.01, `${corner} is none of ${JSON.stringify(points)}`);
  }
});

// Puts a person on the floor where the camera of a frame sees it, 1.2 to 4 m away; false if it sees none.
async function stand_in_view(place) {
  const about = await viewer.page.evaluate(async (n) => (await fetch(`/api/play/frame.json?n=${n}`)).json(), place);
  const spots = await viewer.page.evaluate(() => Array.from({ length: 300 }, () => globalThis.panoptic_play.crew.floor.random()));
  const m = about.world_from_camera;
  const { width, height, fx, fy, cx, cy } = about.camera;
  const found = spots.find((spot) => {
    const [x, y, z] = to_world([spot[0], 1, spot[2]]).map((value, i) => value - m[4 * i + 3]);
    const [right, down, ahead] = [0, 1, 2].map((k) => x * m[k] + y * m[4 + k] + z * m[8 + k]);
    const [u, v] = [(fx * right) / ahead + cx, (fy * down) / ahead + cy];
    return ahead > 1.2 && ahead < 4 && u > 0.15 * width && u < 0.85 * width && v > 0.1 * height && v < 0.9 * height;
  });
  return found !== undefined && viewer.page.evaluate((at) => globalThis.panoptic_play.crew.add_person(at) !== null, found);
}

// Two pictures of the canvas, with and without the figures, of one moment: nothing moves in between, and none is an older one.
async function pictures_of_a_moment() {
  const [shown, hidden] = await viewer.page.evaluate(() => {
    const play = globalThis.panoptic_play;
    const take = (on) => {
      play.show_figures(on);
      play.picture_now();
      return document.querySelector('canvas#surface').toDataURL('image/png').split(',')[1];
    };
    return [take(false), take(true)].reverse();
  });
  return [shown, hidden].map((text) => decode_png(Buffer.from(text, 'base64')));
}

// Pixels whose surroundings all changed, or all stayed: [x, y, changed].
function clear_pixels(a, b) {
  const changed = (x, y) => {
    const at = (y * a.width + x) * a.channels;
    return [0, 1, 2].some((k) => a.pixels[at + k] !== b.pixels[at + k]);  // skin may be almost as brown as the wood behind it
  };
  const found = [];
  for (let y = 195; y < a.height - 110; y += kEvery_px) {  // between the bars
    for (let x = 30; x < a.width - 30; x += kEvery_px) {
      const all = [[0, 0], [-4, 0], [4, 0], [0, -4], [0, 4]].map(([dx, dy]) => changed(x + dx, y + dy));
      if (all.every((one) => one === all[0])) found.push([x, y, all[0]]);
    }
  }
  return found;
}

test('Play: in the camera view the depth of the map hides figures, pixel by pixel', async () => {
  await viewer.page.evaluate(() => globalThis.panoptic_play.clear());
  await viewer.page.keyboard.press('k');
  await viewer.until(async () => viewer.page.getByRole('button', { name: 'Frame before' }).isVisible(), 'the camera view never came');
  const count = { seen: 0, hidden: 0 };
  for (let place = 0; place < 150 && (count.seen < 60 || count.hidden < 10); place += 14) {
    await viewer.page.evaluate((n) => globalThis.panoptic_play.show_frame(n), place);
    if (!(await stand_in_view(place))) continue;
    await viewer.page.evaluate(() => { globalThis.panoptic_play.advance(0); globalThis.panoptic_play.active = false; });  // nobody breathes
    const pixels = clear_pixels(...await pictures_of_a_moment());
    const distances = await viewer.page.evaluate((at) => globalThis.panoptic_play.distances(at), pixels);
    distances.forEach(({ figure_m, surface_m }, i) => {
      if (figure_m === null || (surface_m !== null && Math.abs(figure_m - surface_m) < 0.04)) return;
      const is_before = surface_m === null || figure_m < surface_m;
      ++count[is_before ? 'seen' : 'hidden'];
      assert.equal(pixels[i][2], is_before, `${JSON.stringify({ place, figure_m, surface_m })} at ${pixels[i]}`);
    });
    if (place === 0 || count.seen < 100) await viewer.screenshot(`play_camera_view_${place}`);
    await viewer.page.evaluate(() => { globalThis.panoptic_play.clear(); globalThis.panoptic_play.show(true); });
  }
  assert.ok(count.seen >= 60 && count.hidden >= 10, JSON.stringify(count));
  await viewer.page.keyboard.press('k');
});

for (const colorScheme of ['light', 'dark']) {
  test(`Play: a tap on a small ${colorScheme} screen sends somebody there`, async () => {
    const phone = await open(await program.url(), { colorScheme, viewport: { width: 420, height: 800 }, hasTouch: true });
    try {
      const spot = await phone.page.evaluate(() => {
        const play = globalThis.panoptic_play;
        play.add_person();
        const [{ actor: { place } }] = play.crew.people;
        for (let i = 0; i < 200; ++i) {
          const to = play.crew.floor.random();
          if (Math.hypot(to[0] - place[0], to[2] - place[2]) > 0.8 && play.crew.floor.way(place, to) !== null) return to;
        }
        return null;
      });
      assert.ok(spot, 'nothing is far enough');
      await phone.page.touchscreen.tap(...await middle_of(spot, phone));
      const place = () => phone.page.evaluate(() => globalThis.panoptic_play.log().people[0].place);
      await phone.until(async () => {
        const [x, , z] = await place();
        return Math.hypot(x - spot[0], z - spot[2]) < 0.15;
      }, 'nobody came');
      await phone.screenshot(`play_touch_${colorScheme}`);
    } finally {
      assert.deepEqual(await phone.close(), []);
    }
  });
}

// How often that is depends on the machine and on what else it does; how the parts compare does not.
test('Play: five people are moved in milliseconds, and drawn in less time than their home', async (t) => {
  const found = await viewer.page.evaluate(async () => {
    const play = globalThis.panoptic_play;
    play.clear();
    for (let i = 0; i < 5; ++i) play.add_person();
    const [{ actor: { place: [x, , z] } }] = play.crew.people;
    play.look([x + 2, 1.8, z + 2], [x, 0.8, z]);
    play.toggle('alone', true);
    const gl = document.querySelector('canvas#surface').getContext('webgl2');
    const ms_of = (act) => { const began_ms = performance.now(); act(); return performance.now() - began_ms; };
    const draw = (shown) => ms_of(() => {
      play.show_figures(shown);
      play.picture_now();
      gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));  // waits until it is drawn
    });
    const rounds = Array.from({ length: 9 }, () => ({ move: ms_of(() => play.advance(1 / 30)), without: draw(false), whole: draw(true) }));
    const middle = (name) => rounds.map((round) => round[name]).sort((a, b) => a - b)[4];
    const began_ms = performance.now();
    let pictures = 0;
    for (; performance.now() - began_ms < 5000; ++pictures) await play.drawn();
    play.toggle('alone', false);
    return { move_ms: middle('move'), without_ms: middle('without'), whole_ms: middle('whole'), pictures_per_s: (1000 * pictures) / (performance.now() - began_ms) };
  });
  t.diagnostic(JSON.stringify(found));
  assert.ok(found.move_ms < 10 && found.whole_ms < 2 * found.without_ms, JSON.stringify(found));
});

test('Play: a saved page plays from the disk', async () => {
  const folder = join(work, 'web');
  run('export-web', map_file, '-o', folder, '--camera-frames', '3');
  const saved = await open(pathToFileURL(join(folder, 'index.html')).href);
  try {
    await saved.until(async () => (await saved.counts()).triangles > 0, 'the surface never came');
    await saved.page.evaluate(() => globalThis.panoptic_play.add_person());
    assert.equal((await saved.page.evaluate(() => globalThis.panoptic_play.log())).people.length, 1);
    await saved.page.keyboard.press('k');
    await saved.until(async () => saved.button('Frame before').isVisible(), 'the camera view never came');
    await saved.screenshot('play_saved');
  } finally {
    assert.deepEqual(await saved.close(), []);
  }
});

test('Play: a folder without a map says that it needs one', async () => {
  const other = new Program(['view', map_folder, '--port', '0']);
  const guest = await Viewer.open(browser, await other.url());
  try {
    await guest.settle();
    await guest.button('Play').click();
    await guest.page.getByText('figures and distances need a map file').waitFor();
  } finally {
    assert.deepEqual((await guest.close()).filter((text) => !/404/.test(text)), []);
    await other.stop();
  }
});
