// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The binary answer of /api/chunks, as docs/viewer_protocol.md draws it. Nothing here knows about drawing.

const kMagic = 0x32434650;  // "PFC2"
const kHeaderBytes = 40;
const kVertexBytes = 16;
const kMostVertices = 1 << 20;  // far above what one block can hold: a wrong length must not take memory

export const kUnitsPerBlock = 32768;

function refuse(what) {
  throw new Error(`/api/chunks: ${what}`);
}

function padded(bytes) {
  return (bytes + 3) & ~3;
}

function read_header(view, at) {
  return {
    x: view.getInt32(at, true),
    y: view.getInt32(at + 4, true),
    z: view.getInt32(at + 8, true),
    vertices: view.getUint32(at + 12, true),
    triangles: view.getUint32(at + 16, true),
    version: Number(view.getBigUint64(at + 20, true)),
    vertex_bytes: view.getUint32(at + 28, true),
    index_bytes: view.getUint32(at + 32, true),
    id_count: view.getUint32(at + 36, true),
  };
}

// The chunks of one answer, still encoded: [{key, x, y, z, version, vertices, triangles, ids, encoded_vertices, encoded_indices}].
export function parse_chunks(buffer) {
  const view = new DataView(buffer);
  if (buffer.byteLength < 8 || view.getUint32(0, true) !== kMagic) refuse('this is not a list of chunks');
  const count = view.getUint32(4, true);
  const chunks = [];
  let at = 8;
  for (let i = 0; i < count; ++i) {
    if (at + kHeaderBytes > buffer.byteLength) refuse(`ends inside chunk ${i} of ${count}`);
    const header = read_header(view, at);
    at += kHeaderBytes;
    const ids_at = at + padded(header.vertex_bytes) + padded(header.index_bytes);
    const end = ids_at + 4 * header.id_count;
    if (end > buffer.byteLength) refuse(`ends inside chunk ${i} of ${count}`);
    if (header.vertices > kMostVertices || header.triangles > 2 * kMostVertices) refuse(`chunk ${i} is too large`);
    chunks.push({
      ...header,
      key: `${header.x},${header.y},${header.z}`,
      ids: Uint32Array.from({ length: header.id_count }, (_, k) => view.getUint32(ids_at + 4 * k, true)),
      encoded_vertices: new Uint8Array(buffer, at, header.vertex_bytes),
      encoded_indices: new Uint8Array(buffer, at + padded(header.vertex_bytes), header.index_bytes),
    });
    at = end;
  }
  return chunks;
}

// The data for the graphics card, 16 bytes per vertex in three arrays:
//   places   u16 x 4: position in the block, row of `rows`     normals  i8 x 4: unit normal x 127, 0
//   colors   u8 x 4: red, green, blue, confidence             indices  u16, or u32 where one chunk has more vertices
// `rows` says for each of the chunk's ids which row of the table of labels it has (labels.js).
export function decode_chunk(chunk, decoder, rows) {
  const { vertices, triangles } = chunk;
  const bytes = new Uint8Array(vertices * kVertexBytes);
  const indices = new Uint32Array(triangles * 3);
  if (vertices > 0) decoder.decodeGltfBuffer(bytes, vertices, kVertexBytes, chunk.encoded_vertices, 'ATTRIBUTES', 'NONE');
  if (triangles > 0) decoder.decodeGltfBuffer(new Uint8Array(indices.buffer), triangles * 3, 4, chunk.encoded_indices, 'TRIANGLES', 'NONE');
  const words = new Uint16Array(bytes.buffer);
  const places = new Uint16Array(vertices * 4);
  const normals = new Int8Array(vertices * 4);
  const colors = new Uint8Array(vertices * 4);
  for (let i = 0; i < vertices; ++i) {
    const byte = i * kVertexBytes;
    for (let k = 0; k < 3; ++k) places[4 * i + k] = words[8 * i + k];
    if (words[8 * i + 3] >= rows.length) refuse(`chunk ${chunk.key} names an id that it lacks`);
    places[4 * i + 3] = rows[words[8 * i + 3]];
    for (let k = 0; k < 3; ++k) normals[4 * i + k] = (bytes[byte + 8 + k] << 24) >> 24;
    for (let k = 0; k < 3; ++k) colors[4 * i + k] = bytes[byte + 12 + k];
    colors[4 * i + 3] = bytes[byte + 11];
  }
  for (let i = 0; i < indices.length; ++i) if (indices[i] >= vertices) refuse(`chunk ${chunk.key} names a vertex that it lacks`);
  return { places, normals, colors, indices: vertices <= 0xffff ? Uint16Array.from(indices) : indices };
}
