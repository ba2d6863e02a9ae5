// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Many chunks in one drawing: a map has thousands of blocks, and a browser draws a hundred large meshes faster than thousands of
// small ones. A region is a cube of blocks; when one of its chunks changes the region is put together anew.
import { kUnitsPerBlock } from './protocol.js';

export const kBlocksPerRegion = 4;     // along each side
export const kUnitsPerMergedBlock = 13107;  // (4 + 1) blocks in 16 bits: vertices may lie one block beyond; 0.03 mm at 2.4 cm voxels

// The region of block (x, y, z): its key, its first block, and where the block is in it.
export function region_of(x, y, z) {
  const first = [x, y, z].map((c) => Math.floor(c / kBlocksPerRegion) * kBlocksPerRegion);
  return { key: first.join(','), first, offset: [x - first[0], y - first[1], z - first[2]] };
}

// parts: [{offset, arrays}], arrays as decode_chunk makes them. The same arrays for the region, places in kUnitsPerMergedBlock.
export function merge(parts) {
  const vertices = parts.reduce((sum, { arrays }) => sum + arrays.places.length / 4, 0);
  const corners = parts.reduce((sum, { arrays }) => sum + arrays.indices.length, 0);
  const places = new Uint16Array(4 * vertices);
  const normals = new Int8Array(4 * vertices);
  const colors = new Uint8Array(4 * vertices);
  const indices = vertices <= 0xffff ? new Uint16Array(corners) : new Uint32Array(corners);
  let vertex = 0;
  let corner = 0;
  for (const { offset, arrays } of parts) {
    place_into(places, 4 * vertex, arrays.places, offset);
    normals.set(arrays.normals, 4 * vertex);
    colors.set(arrays.colors, 4 * vertex);
    for (const index of arrays.indices) indices[corner++] = vertex + index;
    vertex += arrays.places.length / 4;
  }
  return { places, normals, colors, indices };
}

function place_into(target, at, source, offset) {
  const scale = kUnitsPerMergedBlock / kUnitsPerBlock;
  for (let i = 0; i < source.length; i += 4) {
    for (let k = 0; k < 3; ++k) target[at + i + k] = Math.round(offset[k] * kUnitsPerMergedBlock + source[i + k] * scale);
    target[at + i + 3] = source[i + 3];
  }
}
