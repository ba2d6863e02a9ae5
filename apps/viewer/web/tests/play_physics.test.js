// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { Physics, start_physics } from '../src/play/physics.js';

await start_physics();

// A table top of 1 x 1 m.
const table = (y, version) => ({ key: '0,0,0', version, places: new Float32Array([0, y, 0, 1, y, 0, 1, y, 1, 0, y, 1]), indices: [0, 2, 1, 0, 3, 2] });

function height_after(physics, seconds) {
  for (let i = 0; i < seconds * 10; ++i) physics.step(0.1);
  return physics.at(0).place[1];
}

test('Physics: a thing goes with the table when the frame changes, and falls when the table is gone', () => {
  const physics = new Physics();
  physics.solid([table(0.75, 1)]);
  physics.put('cup', [0.5, 0.75, 0.5]);
  assert.ok(Math.abs(height_after(physics, 2) - 0.75) < 0.01);
  const turn = [0, Math.sin(0.05), 0, Math.cos(0.05)];
  physics.move(turn, [0, 0.1, 0]);
  physics.solid([table(0.85, 1)]);
  assert.ok(Math.abs(height_after(physics, 2) - 0.85) < 0.01, `${height_after(physics, 0)}`);
  physics.move([0, 0, 0, 1], [0, 0, 0]);
  assert.ok(height_after(physics, 3) < 0.1, `${height_after(physics, 0)}`);
  physics.destroy();
});
