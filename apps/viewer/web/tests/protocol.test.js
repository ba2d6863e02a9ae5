// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { MeshoptDecoder } from 'meshoptimizer/decoder';
import { MeshoptEncoder } from 'meshoptimizer/encoder';
import { decode_chunk, parse_chunks } from '../src/protocol.js';

await MeshoptDecoder.ready;
await MeshoptEncoder.ready;

// A vertex as docs/viewer_protocol.md lays it out, byte by byte.
function vertex_bytes({ place, id, normal, confidence, color }, ids) {
  const bytes = new DataView(new ArrayBuffer(16));
  place.forEach((value, k) => bytes.setUint16(2 * k, value, true));
  bytes.setUint16(6, ids.indexOf(id), true);
  normal.forEach((value, k) => bytes.setInt8(8 + k, value));
  bytes.setUint8(11, confidence);
  color.forEach((value, k) => bytes.setUint8(12 + k, value));
  return new Uint8Array(bytes.buffer);
}

function chunk_bytes({ block, version, vertices, triangles, ids = kIds }) {
  if (vertices.length === 0) ids = [];
  const raw = new Uint8Array(vertices.length * 16);
  vertices.forEach((vertex, i) => raw.set(vertex_bytes(vertex, kIds), 16 * i));
  const indices = new Uint8Array(new Uint32Array(triangles.flat()).buffer);
  const runs = [
    vertices.length === 0 ? new Uint8Array(0) : MeshoptEncoder.encodeGltfBuffer(raw, vertices.length, 16, 'ATTRIBUTES', 0),
    triangles.length === 0 ? new Uint8Array(0) : MeshoptEncoder.encodeGltfBuffer(indices, triangles.length * 3, 4, 'TRIANGLES', 0),
  ];
  const padded = runs.map((run) => (run.length + 3) & ~3);
  const bytes = new Uint8Array(40 + padded[0] + padded[1] + 4 * ids.length);
  const view = new DataView(bytes.buffer);
  block.forEach((value, k) => view.setInt32(4 * k, value, true));
  view.setUint32(12, vertices.length, true);
  view.setUint32(16, triangles.length, true);
  view.setBigUint64(20, BigInt(version), true);
  view.setUint32(28, runs[0].length, true);
  view.setUint32(32, runs[1].length, true);
  view.setUint32(36, ids.length, true);
  bytes.set(runs[0], 40);
  bytes.set(runs[1], 40 + padded[0]);
  ids.forEach((id, k) => view.setUint32(40 + padded[0] + padded[1] + 4 * k, id, true));
  return bytes;
}

function answer(chunks) {
  const all = chunks.map(chunk_bytes);
  const bytes = new Uint8Array(8 + all.reduce((sum, part) => sum + part.length, 0));
  bytes.set(new TextEncoder().encode('PFC2'));
  new DataView(bytes.buffer).setUint32(4, chunks.length, true);
  let at = 8;
  for (const part of all) {
    bytes.set(part, at);
    at += part.length;
  }
  return bytes.buffer;
}

const kVertices = [
  { place: [0, 1, 32768], id: 57, normal: [127, 0, -127], confidence: 255, color: [1, 2, 3] },
  { place: [65535, 300, 400], id: 4_294_967_294, normal: [-1, 2, -3], confidence: 0, color: [255, 128, 0] },
  { place: [7, 8, 9], id: 0, normal: [0, -127, 0], confidence: 17, color: [9, 8, 7] },
];
const kIds = [0, 57, 4_294_967_294];
const kRows = [0, 300, 65535];  // where the table of labels has them
const kTriangle = { block: [-1, 0, 3], version: 17, vertices: kVertices, triangles: [[0, 1, 2]] };
const kEmpty = { block: [2000000, -5, 0], version: 18, vertices: [], triangles: [] };

test('Protocol: reads every field of a chunk back', () => {
  const chunks = parse_chunks(answer([kTriangle, kEmpty]));
  assert.deepEqual(chunks.map(({ key, version, vertices, triangles }) => ({ key, version, vertices, triangles })), [
    { key: '-1,0,3', version: 17, vertices: 3, triangles: 1 },
    { key: '2000000,-5,0', version: 18, vertices: 0, triangles: 0 },
  ]);
  assert.deepEqual([...chunks[0].ids], kIds);
  const arrays = decode_chunk(chunks[0], MeshoptDecoder, kRows);
  kVertices.forEach((vertex, i) => {
    assert.deepEqual([...arrays.places.slice(4 * i, 4 * i + 4)], [...vertex.place, kRows[kIds.indexOf(vertex.id)]]);
    assert.deepEqual([...arrays.normals.slice(4 * i, 4 * i + 3)], vertex.normal);
    assert.deepEqual([...arrays.colors.slice(4 * i, 4 * i + 4)], [...vertex.color, vertex.confidence]);
  });
  assert.deepEqual([...arrays.indices], [0, 1, 2]);
  assert.equal(decode_chunk(chunks[1], MeshoptDecoder, []).places.length, 0);
});

test('Protocol: refuses an answer that was cut anywhere', () => {
  const whole = answer([kTriangle, kTriangle]);
  for (let length = 0; length < whole.byteLength; ++length) assert.throws(() => parse_chunks(whole.slice(0, length)), /\/api\/chunks/);
});

test('Protocol: refuses what is not a list of chunks', () => {
  const other = answer([kTriangle]);
  new Uint8Array(other)[0] = 80 ^ 1;
  assert.throws(() => parse_chunks(other), /not a list of chunks/);
});

test('Protocol: takes no memory for a chunk that claims to be huge', () => {
  const huge = answer([kTriangle]);
  new DataView(huge).setUint32(8 + 12, 0xffffffff, true);
  assert.throws(() => parse_chunks(huge), /too large/);
});

test('Protocol: refuses a triangle of a vertex that is not there', () => {
  const [chunk] = parse_chunks(answer([{ ...kTriangle, triangles: [[0, 1, 3]] }]));
  assert.throws(() => decode_chunk(chunk, MeshoptDecoder, kRows), /vertex that it lacks/);
});

test('Protocol: refuses a vertex with an id that is not there', () => {
  const [chunk] = parse_chunks(answer([{ ...kTriangle, ids: [0, 57] }]));
  assert.throws(() => decode_chunk(chunk, MeshoptDecoder, kRows.slice(0, 2)), /id that it lacks/);
});
