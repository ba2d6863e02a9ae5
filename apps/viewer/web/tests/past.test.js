// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { box_at, count_until, floor_places, Past, side_of, was_there } from '../src/past.js';
import { ghost_text, left_out_text, moment_text, time_text } from '../src/past_text.js';
import { arrow_points } from '../src/past_view.js';
import { playing_speed } from '../src/time_slider.js';

const kUp = [0, 0, 1];
const object = (id, first_s, gone_s = null, more = {}) =>
  ({ id, class_id: 12, color: [1, 2, 3], min_m: [0, 0, 0], max_m: [1, 1, 1], first_s, gone_s, appeared: false, moved_from: null, moved_to: null, ...more });
const kNone = { objects: 0, tracks: 0, boxes: 0, forgotten_boxes: 0 };
const message = (more = {}) => ({
  start_s: 0, end_s: 40, left_out: kNone,
  objects: [object(50, 0), object(51, 5, 31), object(52, 0, 20, { moved_to: 53 }), object(53, 18, null, { appeared: true, moved_from: 52 }), object(54, 25, null, { appeared: true })],
  tracks: [{ id: 1, class_id: 3, boxes: [10, 0, 0, 0, 1, 1, 2, 12, 2, 0, 0, 3, 1, 2] }, { id: 2, class_id: 0, boxes: [11, 5, 5, 0, 6, 6, 1, 13, 5, 7, 0, 6, 8, 1] }],
  ...more,
});
const ids = (objects) => objects.map(({ id }) => id);

test('Past: an object is there from when it was seen until it was known to be gone', () => {
  assert.deepEqual([4.9, 5, 30.9, 31].map((time_s) => was_there(object(1, 5, 31), time_s)), [false, true, true, false]);
  assert.equal(was_there(object(1, 5), 1e9), true);
});

test('Past: at a time there are ghosts of what is gone, and the map has what was not there yet', () => {
  const past = new Past(message());
  assert.deepEqual(ids(past.there_at(19)), [50, 51, 52, 53]);
  assert.deepEqual(ids(past.ghosts(19)), [51, 52]);
  assert.deepEqual([...past.not_yet(17)], [53, 54]);
  assert.deepEqual(past.moves(1).map(({ from, to }) => [from.id, to.id]), [[52, 53]]);
  assert.deepEqual(ids(past.ghosts(40)), []);
  assert.deepEqual([...past.not_yet(40)], []);
});

test('Past: whoever moves is between the boxes before and after', () => {
  const past = new Past(message());
  assert.deepEqual(past.moving(11).map(({ track, box }) => [track.id, box.min_m]), [[1, [1, 0, 0]], [2, [5, 5, 0]]]);
  assert.deepEqual(past.moving(12.5).map(({ track }) => track.id), [2]);
  assert.equal(box_at(past.tracks[0], 9.9), null);
  assert.deepEqual(box_at(past.tracks[0], 10).min_m, [0, 0, 0]);
  assert.deepEqual(past.restless(), [[10, 13]]);
});

test('Past: ways lie on the floor in the order of time, and only so much of them as was walked', () => {
  const { places, times } = new Past(message()).segments(kUp);
  assert.deepEqual(times, [12, 13]);
  assert.deepEqual(places.slice(0, 5), [0.5, 0.5, 0.03, 2.5, 0.5]);
  assert.deepEqual([11.9, 12, 13].map((time_s) => count_until(times, time_s)), [0, 1, 2]);
  assert.equal(new Past(message()).segments(kUp, ({ class_id }) => class_id === 3).times.length, 1);
});

test('Past: feet that are out of the picture do not lift the way', () => {
  const boxes = [0, 0.2, 0.4].map((time_s, i) => ({ time_s, min_m: [i, 0, i === 1 ? 0.9 : 0], max_m: [i + 1, 1, 2] }));
  assert.deepEqual(floor_places({ boxes }, kUp).map((place) => place[2].toFixed(2)), ['0.03', '0.03', '0.03']);
  assert.deepEqual(side_of({ min_m: [0, 0, 0], max_m: [2, 4, 6] }, [0, -1, 0], 1), [1, 0, 3]);
});

test('Past: an answer that is not as documented is refused', () => {
  for (const wrong of [{ end_s: -1 }, { objects: 3 }, { objects: [object(1, null)] }, { objects: [object(-1, 0)] }, { objects: [object(1, 0, null, { max_m: [1, 2] })] },
    { tracks: [{ id: 1, class_id: 3, boxes: [1, 2, 3] }] }, { tracks: [{ id: 1, class_id: 3, boxes: [] }] },
    { tracks: Array.from({ length: 1001 }, (_, id) => ({ id, class_id: 0, boxes: [0, 0, 0, 0, 1, 1, 1] })) },
    { tracks: [{ id: 1, class_id: 3, boxes: new Array(7 * 20001).fill(0) }] }]) {
    assert.throws(() => new Past(message(wrong)), /api\/history/, JSON.stringify(wrong).slice(0, 80));
  }
});

test('Past: an arrow follows a thing that was moved twice, and none leads to where it is gone from', () => {
  const moved = (last_gone_s) => new Past(message({ objects: [object(1, 0, 5, { moved_to: 2 }), object(2, 4, 9, { moved_to: 3, moved_from: 1 }), object(3, 8, last_gone_s, { moved_from: 2 })] }));
  assert.deepEqual(moved(null).moves(6).map(({ from, to }) => [from.id, to.id]), [[1, 3], [2, 3]]);
  assert.deepEqual(moved(10).moves(6), []);
});

test('Past: in words', () => {
  assert.deepEqual([0, 7.44, 31, 125].map(moment_text), ['0 s', '7.4 s', '31 s', '2:05']);
  assert.equal(moment_text(1305031102.2, 1305031071.2), '+31 s');
  assert.equal(ghost_text('chair', object(1, 0, 31)), 'chair, gone at 31 s');
  assert.equal(ghost_text('chair', object(1, 0, 7.25, { moved_to: 3 })), 'chair, moved at 7.3 s');
  const past = new Past(message());
  assert.equal(time_text(past, 11), '3 there · 2 moving');
  assert.equal(time_text(past, 1), '2 there');
  assert.equal(time_text(past, null), '1 came · 1 gone · 1 moved · 2 tracks');
  assert.equal(left_out_text(kNone), '');
  assert.equal(left_out_text({ objects: 0, tracks: 1, boxes: 12345, forgotten_boxes: 2 }), 'without 1 track, 12,345 boxes, 2 old boxes');
});

test('Past: an arrow ends where the object is now, and there is none for a thing in its place', () => {
  const points = arrow_points([0, 0, 0], [2, 0, 0], kUp);
  assert.equal(points.length % 6, 0);
  assert.deepEqual(points.slice(0, 3), [0, 0, 0]);
  assert.deepEqual(points.slice(-6, -3), [2, 0, 0]);
  assert.ok(points.every(Number.isFinite));
  assert.ok(arrow_points([0, 0, 0], [0, 0, 2], kUp).every(Number.isFinite), 'straight up');
  assert.deepEqual(arrow_points([1, 1, 1], [1, 1, 1], kUp), []);
});

test('Past: a long recording plays within half a minute, a short one as it was', () => {
  assert.equal(playing_speed(10), 1);
  assert.equal(playing_speed(3600), 120);
});
