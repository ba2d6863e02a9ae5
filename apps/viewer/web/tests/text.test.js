// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { Vector3 } from 'three';
import { nearest_place } from '../src/distances.js';
import { file_name } from '../src/downloads.js';
import { History } from '../src/history.js';
import { best_probability, matches, size_of } from '../src/objects.js';
import { upright } from '../src/stage.js';
import { duration_text, number_text, short_text } from '../src/timeline.js';
import { box_points, frustum_points } from '../src/trail.js';

test('Text: numbers keep about three digits', () => {
  assert.deepEqual([0, 3, 0.126, 9.96, 12.34, 1234.5].map(number_text), ['0', '3', '0.13', '9.96', '12.3', '1,235']);
  assert.equal(number_text(undefined), '–');
  assert.deepEqual([0, 0.04, 1.26, 9.96, 1234.5].map(short_text), ['0', '0', '1.3', '10', '1,235']);
});

test('Text: durations', () => {
  assert.deepEqual([0, 9.9, 61, 3725].map(duration_text), ['0:00', '0:09', '1:01', '1:02:05']);
});

test('Distances: a slice is shown at the height that is nearest', () => {
  assert.equal(nearest_place([-0.1, 0, 0.4, 0.62, 0.7], 0.5), 2);
  assert.equal(nearest_place([1.5], 0.5), 0);
});

test('Text: file names hold nothing that a file system refuses', () => {
  assert.equal(file_name('my kitchen: 2/3'), 'my_kitchen_2_3');
  assert.equal(file_name('../..'), 'map');
});

test('History: forgets what is too old and what is too many', () => {
  const history = new History(10, 3);
  for (const time_s of [0, 1, 2, 3]) history.add('a', time_s, time_s);
  assert.deepEqual(history.points('a').map(([time_s]) => time_s), [1, 2, 3]);
  history.add('a', 12.5, 0);
  assert.deepEqual(history.points('a').map(([time_s]) => time_s), [3, 12.5]);
  history.add('a', 13, NaN);
  assert.equal(history.points('a').length, 2);
});

test('Objects: every word of a search must be found, in any order', () => {
  const object = { name: 'office_chair_57' };
  assert.ok(matches(object, 'chair', '57 CHAIR'));
  assert.ok(!matches(object, 'chair', 'chair 58'));
  assert.ok(matches(object, 'chair', ' '));
});

test('Objects: size and confidence', () => {
  assert.deepEqual(size_of({ min_m: [0, 1, 2], max_m: [1, 3, 2] }), [1, 2, 0]);
  assert.equal(best_probability({ class_id: 4, probabilities: [[3, 0.4], [4, 0.6]] }), 0.6);
  assert.equal(best_probability({ class_id: 4, probabilities: [] }), 0);
});

test('Stage: up is up, and a little more of it does not spin the map', () => {
  for (const up of [[0, -1, 0], [0.02, -1, 0.01], [-0.02, -1, -0.01], [0, 0, 1], [0, 1, 0], [1, 0, 0]]) {
    const direction = new Vector3(...up).normalize();
    assert.ok(direction.clone().applyQuaternion(upright(direction)).distanceTo(new Vector3(0, 1, 0)) < 1e-6);
  }
  const ahead = new Vector3(0, 0, 1);
  const one = ahead.clone().applyQuaternion(upright(new Vector3(0.02, -1, 0.01).normalize()));
  const other = ahead.clone().applyQuaternion(upright(new Vector3(-0.02, -1, -0.01).normalize()));
  assert.ok(one.distanceTo(other) < 0.1);
});

test('Trail: a box has twelve edges, a frustum passes through the corners of the image', () => {
  assert.equal(box_points([0, 0, 0], [1, 2, 3]).length, 12 * 2 * 3);
  const points = frustum_points({ width: 640, height: 480, fx: 320, fy: 320, cx: 320, cy: 240 }, 2);
  assert.deepEqual(points.slice(0, 6), [-2, -1.5, 2, 2, -1.5, 2]);
});
