// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { kUnitsPerBlock } from '../src/protocol.js';
import { kUnitsPerMergedBlock, merge, region_of } from '../src/regions.js';

const chunk = (seed, vertices) => ({
  places: Uint16Array.from({ length: 4 * vertices }, (_, i) => (seed * 7919 + i * 104729) % (i % 4 === 3 ? 65536 : 2 * kUnitsPerBlock)),
  normals: Int8Array.from({ length: 4 * vertices }, (_, i) => (seed + i) % 127),
  colors: Uint8Array.from({ length: 4 * vertices }, (_, i) => (seed * 31 + i) % 256),
  indices: Uint16Array.from({ length: 3 * vertices }, (_, i) => (i * 5 + seed) % vertices),
});

test('Regions: a block on the far side of zero lies in the region before it', () => {
  assert.deepEqual(region_of(0, 3, 4), { key: '0,0,4', first: [0, 0, 4], offset: [0, 3, 0] });
  assert.deepEqual(region_of(-1, -4, -5), { key: '-4,-4,-8', first: [-4, -4, -8], offset: [3, 0, 3] });
});

test('Regions: merging moves no vertex by more than half a unit and changes nothing else', () => {
  const parts = [{ offset: [0, 0, 0], arrays: chunk(1, 5) }, { offset: [3, 3, 3], arrays: chunk(2, 9) }, { offset: [1, 0, 2], arrays: chunk(3, 1) }];
  const whole = merge(parts);
  let vertex = 0;
  let corner = 0;
  for (const { offset, arrays } of parts) {
    const count = arrays.places.length / 4;
    for (let i = 0; i < count; ++i) {
      for (let k = 0; k < 3; ++k) {
        const blocks = offset[k] + arrays.places[4 * i + k] / kUnitsPerBlock;
        assert.ok(Math.abs(whole.places[4 * (vertex + i) + k] / kUnitsPerMergedBlock - blocks) <= 0.5001 / kUnitsPerMergedBlock);
      }
      assert.equal(whole.places[4 * (vertex + i) + 3], arrays.places[4 * i + 3]);
    }
    assert.deepEqual(whole.normals.slice(4 * vertex, 4 * (vertex + count)), arrays.normals);
    assert.deepEqual(whole.colors.slice(4 * vertex, 4 * (vertex + count)), arrays.colors);
    assert.deepEqual([...whole.indices.slice(corner, corner + arrays.indices.length)], [...arrays.indices].map((index) => index + vertex));
    vertex += count;
    corner += arrays.indices.length;
  }
  assert.equal(whole.places.length, 4 * vertex);
  assert.equal(whole.indices.length, corner);
});

test('Regions: more vertices than 16 bits count get indices of 32 bits', () => {
  const large = chunk(1, 40000);
  const whole = merge([{ offset: [0, 0, 0], arrays: large }, { offset: [1, 0, 0], arrays: large }]);
  assert.ok(whole.indices instanceof Uint32Array);
  assert.equal(whole.indices[large.indices.length], large.indices[0] + 40000);
});
