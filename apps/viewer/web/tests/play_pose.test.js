// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { Vector3 } from 'three';
import { lying, mix, sitting, standing, stride_of, walking } from '../src/play/pose.js';
import { shape_of } from '../src/play/shape.js';
import { joints_of, knee_of } from '../src/play/skeleton.js';

const shape = shape_of(1.64);
const soles = (joints) => joints.legs.map(({ ankle }) => ankle.y - shape.ankle);

test('Pose: who stands is as tall as it says, on both soles', () => {
  const joints = joints_of(standing(shape), shape, new Vector3(1, 0, 2), 0.7);
  const height = joints.head.y + shape.head * 1.08;
  assert.ok(Math.abs(height - 1.64) < 0.05, `${height}`);
  for (const sole of soles(joints)) assert.ok(Math.abs(sole) < 1e-6);
});

test('Pose: a foot on the floor does not slide while the body walks on', () => {
  const speed = 0.9;
  const stride = stride_of(shape, speed);
  const flat = 0.45;  // until the heel rises
  const places = [];
  for (let t = 0; t <= flat; t += 0.01) {
    const joints = joints_of(walking(shape, t, speed), shape, new Vector3(0, 0, t * stride), 0);
    places.push(joints.legs[0].ankle.z);
  }
  assert.ok(Math.max(...places) - Math.min(...places) < 0.015, `${Math.max(...places) - Math.min(...places)} m`);
});

test('Pose: walking soles are never below the floor, and one is always within a centimetre or two of it', () => {
  for (let phase = 0; phase < 1; phase += 0.01) {
    const heights = soles(joints_of(walking(shape, phase, 1), shape, new Vector3(), 0));
    for (const height of heights) assert.ok(height > -0.005, `${height} at ${phase}`);
    assert.ok(Math.min(...heights) < 0.03, `${heights} at ${phase}`);
  }
});

test('Pose: who sits has the pelvis over the seat and the soles on the floor', () => {
  for (const seat of [0.38, 0.45, 0.5]) {
    const joints = joints_of(sitting(shape, seat), shape, new Vector3(2, 0, 3), 1);
    assert.ok(Math.hypot(joints.pelvis.x - 2, joints.pelvis.z - 3) < 0.02);
    assert.ok(Math.abs(joints.pelvis.y - seat - shape.buttocks) < 1e-6);
    for (const sole of soles(joints)) assert.ok(Math.abs(sole) < 0.03, `${sole} above the floor on a seat of ${seat}`);
    for (const { knee } of joints.legs) assert.ok((knee.x - 2) * Math.sin(1) + (knee.z - 3) * Math.cos(1) > 0.25);
  }
});

test('Pose: who lies is level, with the head away from the feet', () => {
  const joints = joints_of(lying(shape, 0.5), shape, new Vector3(), 0);
  for (const y of [joints.pelvis.y, joints.head.y, joints.legs[0].knee.y, joints.legs[1].ankle.y]) assert.ok(y > 0.5 && y < 0.78, `${y}`);
  assert.ok(joints.head.z < -0.5 && joints.legs[0].ankle.z > 0.6);
});

test('Pose: a mixture ends where its parts are', () => {
  const [a, b] = [standing(shape), sitting(shape, 0.45)];
  assert.deepEqual(mix(a, b, 0), a);
  assert.deepEqual(mix(a, b, 1), b);
  assert.ok(Math.abs(mix(a, b, 0.5).pelvis[1] - (a.pelvis[1] + b.pelvis[1]) / 2) < 1e-9);
});

test('Pose: bones keep their lengths', () => {
  for (const far of [0.1, 0.5, 0.8, 1.2]) {
    const { knee, ankle } = knee_of(new Vector3(0, 1, 0), new Vector3(0, 1 - far, 0.1), shape, new Vector3(0, 0, 1));
    assert.ok(Math.abs(knee.distanceTo(new Vector3(0, 1, 0)) - shape.thigh) < 1e-3);
    assert.ok(Math.abs(knee.distanceTo(ankle) - shape.shin) < 2e-3);
  }
});
