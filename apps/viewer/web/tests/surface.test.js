// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { Material, Vector3 } from 'three';
import { Labels } from '../src/labels.js';
import { Surface } from '../src/surface.js';

// Hands out what the chunk says instead of decoding: what is under test is what happens to it.
const kDecoder = {
  decodeGltfBuffer(target, count, size, source, mode) {
    if (mode === 'TRIANGLES') return new Uint32Array(target.buffer).set(Uint32Array.from({ length: count }, (_, i) => i % 3));
    for (let i = 0; i < count; ++i) {
      new Uint16Array(target.buffer).set([100 * i, 200, 300, source[i % source.length]], 8 * i);
      target.set([0, 0, 127], 16 * i + 8);
    }
    return null;
  },
};
const encoded = (x, version, id, triangles = 1) => ({
  key: `${x},0,0`, x, y: 0, z: 0, version, vertices: triangles * 3, triangles, ids: [id], encoded_vertices: [0], encoded_indices: [],
});

function surface_with(chunks) {
  const labels = new Labels();
  labels.reset({ first_thing: 5, classes: [] });
  const surface = new Surface({ seen: new Material() }, kDecoder, labels);
  surface.reset({ block_size_m: 0.4 });
  for (const chunk of chunks) surface.put(chunk);
  surface.build();
  return surface;
}

test('Surface: counts each chunk once, whatever its version', () => {
  const surface = surface_with([encoded(0, 1, 7), encoded(1, 1, 9), encoded(0, 2, 8, 2)]);
  assert.deepEqual([surface.chunk_count, surface.triangles, surface.vertices], [2, 3, 9]);
  assert.deepEqual([7, 8, 9].map((id) => surface.count_of(id)), [0, 6, 3]);
});

test('Surface: an older answer that arrives late changes nothing', () => {
  const surface = surface_with([encoded(0, 5, 7), encoded(0, 4, 8)]);
  assert.deepEqual([surface.count_of(7), surface.count_of(8)], [3, 0]);
});

test('Surface: a chunk that lost its surface takes it off the map', () => {
  const surface = surface_with([encoded(0, 1, 7), encoded(0, 2, 7, 0)]);
  assert.deepEqual([surface.chunk_count, surface.triangles, surface.count_of(7), surface.group.children.length], [0, 0, 0, 0]);
  assert.ok(surface.box.isEmpty());
});

test('Surface: counts ids beyond 16 bits, and tells them apart within a chunk', () => {
  const two = { ...encoded(0, 1, 7), ids: [4_000_000_000, 70_000], encoded_vertices: [0, 1] };
  const surface = surface_with([two]);
  assert.deepEqual([4_000_000_000, 70_000, 0].map((id) => surface.count_of(id)), [2, 1, 0]);
  surface.put(encoded(0, 2, 70_000));
  assert.deepEqual([4_000_000_000, 70_000].map((id) => surface.count_of(id)), [0, 3]);
});

test('Surface: frees the geometry that it replaces', () => {
  const surface = surface_with([encoded(0, 1, 7), encoded(9, 1, 7)]);
  const freed = [];
  for (const mesh of surface.group.children) mesh.geometry.addEventListener('dispose', () => freed.push(mesh));
  const [first, second] = [...surface.group.children];
  surface.put(encoded(0, 2, 7));
  surface.build();
  assert.deepEqual(freed, [first]);
  assert.equal(surface.group.children.length, 2);
  surface.reset({ block_size_m: 0.4 });
  assert.equal(freed.length, 2);
  assert.ok(freed.includes(second));
  assert.equal(surface.group.children.length, 0);
});

test('Surface: blocks near each other are drawn at once', () => {
  const surface = surface_with([0, 1, 2, 3, 4].map((x) => encoded(x, 1, 7)));
  assert.equal(surface.group.children.length, 2);
});

test('Surface: the box is where the vertices are, in metres', () => {
  const { box } = surface_with([encoded(-2, 1, 7)]);
  const unit = 0.4 / 32768;
  assert.ok(box.min.distanceTo(new Vector3(-0.8, 200 * unit, 300 * unit)) < 1e-6);
  assert.ok(box.max.distanceTo(new Vector3(-0.8 + 200 * unit, 200 * unit, 300 * unit)) < 1e-6);
});

test('Surface: is looked at from the side that its front faces', () => {
  const side = surface_with([encoded(0, 1, 7, 40)]).best_side(new Vector3(0, 1, 0));
  assert.ok(side.dot(new Vector3(0, 0, 1)) > 0.99);
});
