// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The chunks of the surface: replaced when a newer version arrives, counted, merged into regions (regions.js) that three.js
// draws. Replaced parts are freed at once; regions out of view are left out by three.js, which has a sphere for each of them.
import { Box3, BufferAttribute, BufferGeometry, Group, Mesh, Sphere, Vector3 } from 'three';
import { decode_chunk, kUnitsPerBlock } from './protocol.js';
import { kUnitsPerMergedBlock, merge, region_of } from './regions.js';

const kNormalBins = 16;
const kNormalStride = 16;  // every 16th normal tells enough

// The graphics card has its copy after the first drawing: ours would only double the memory.
function attribute(array, size, normalized) {
  return new BufferAttribute(array, size, normalized).onUpload(function forget() { this.array = null; });
}

function geometry_of(arrays) {
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', attribute(arrays.places, 4, false));
  geometry.setAttribute('normal', attribute(arrays.normals, 4, true));
  geometry.setAttribute('color', attribute(arrays.colors, 4, true));
  geometry.setIndex(attribute(arrays.indices, 1, false));
  return geometry;
}

function box_of(places, corner, scale) {
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  for (let i = 0; i < places.length; i += 4) {
    for (let k = 0; k < 3; ++k) {
      low[k] = Math.min(low[k], places[i + k]);
      high[k] = Math.max(high[k], places[i + k]);
    }
  }
  return new Box3(new Vector3(...low).multiplyScalar(scale).add(corner), new Vector3(...high).multiplyScalar(scale).add(corner));
}

export class Surface {
  group = new Group();
  vertices_of = new Map();  // by panoptic id, of those that have any; borders of chunks count twice
  vertices = 0;
  triangles = 0;
  chunk_count = 0;      // those with surface
  #chunks = new Map();  // key -> {version, vertices, triangles, arrays, box, ids, region, offset}; arrays null where empty
  #regions = new Map();  // key -> {first, chunks, mesh}
  #stale = new Set();   // regions to put together anew
  #material;
  #decoder;
  #labels;
  #block_size_m = 1;

  constructor(material, decoder, labels) {
    this.#material = material;
    this.#decoder = decoder;
    this.#labels = labels;
  }

  // Labels are reset by then.
  reset(scene) {
    for (const region of this.#regions.values()) this.#free(region);
    this.#regions.clear();
    this.#stale.clear();
    this.#chunks.clear();
    this.vertices_of.clear();
    this.vertices = 0;
    this.triangles = 0;
    this.chunk_count = 0;
    this.#block_size_m = scene.block_size_m;
  }

  // Answers may overtake each other: an older version never replaces a newer one.
  put(encoded) {
    const before = this.#chunks.get(encoded.key);
    if (before && before.version >= encoded.version) return;
    const chunk = this.#decoded(encoded);
    this.#chunks.set(encoded.key, chunk);
    if (before) this.#count(before, -1);
    this.#count(chunk, 1);
    for (const id of before?.ids.keys() ?? []) this.#labels.drop(id);
    const region = this.#regions.get(chunk.region.key) ?? { first: chunk.region.first, chunks: new Map(), mesh: null };
    this.#regions.set(chunk.region.key, region);
    chunk.arrays ? region.chunks.set(encoded.key, chunk) : region.chunks.delete(encoded.key);
    this.#stale.add(region);
  }

  count_of(id) {
    return this.vertices_of.get(id) ?? 0;
  }

  // Before drawing: puts together what changed since the last time.
  build() {
    for (const region of this.#stale) this.#build(region);
    this.#stale.clear();
  }

  // Everything again: the graphics card lost its copy.
  rebuild() {
    for (const region of this.#regions.values()) this.#stale.add(region);
  }

  #decoded(encoded) {
    const { version, vertices, triangles, x, y, z } = encoded;
    const chunk = { version, vertices, triangles, arrays: null, box: null, ids: new Map(), region: region_of(x, y, z), corner: [x, y, z] };
    if (triangles === 0) return chunk;
    for (const id of encoded.ids) chunk.ids.set(id, 0);
    const rows = Array.from(encoded.ids, (id) => this.#labels.take(id));
    chunk.arrays = decode_chunk(encoded, this.#decoder, rows);
    const { places } = chunk.arrays;
    const counts = new Map(rows.map((row) => [row, 0]));
    for (let i = 3; i < places.length; i += 4) counts.set(places[i], counts.get(places[i]) + 1);
    encoded.ids.forEach((id, k) => chunk.ids.set(id, counts.get(rows[k])));
    chunk.box = box_of(places, new Vector3(x, y, z).multiplyScalar(this.#block_size_m), this.#block_size_m / kUnitsPerBlock);
    return chunk;
  }

  #count(chunk, sign) {
    this.vertices += sign * chunk.vertices;
    this.triangles += sign * chunk.triangles;
    this.chunk_count += chunk.arrays ? sign : 0;
    for (const [id, count] of chunk.ids) {
      const sum = this.count_of(id) + sign * count;
      sum > 0 ? this.vertices_of.set(id, sum) : this.vertices_of.delete(id);
    }
  }

  #build(region) {
    this.#free(region);
    if (region.chunks.size === 0) return;
    const chunks = [...region.chunks.values()];
    const geometry = geometry_of(merge(chunks.map(({ arrays, region: { offset } }) => ({ arrays, offset }))));
    const mesh = new Mesh(geometry, this.#material.seen);
    mesh.position.fromArray(region.first).multiplyScalar(this.#block_size_m);
    mesh.scale.setScalar(this.#block_size_m / kUnitsPerMergedBlock);
    mesh.updateMatrix();
    mesh.matrixAutoUpdate = false;
    const box = new Box3();
    for (const chunk of chunks) box.union(chunk.box);
    geometry.boundingSphere = box.getBoundingSphere(new Sphere()).applyMatrix4(mesh.matrix.clone().invert());
    region.mesh = mesh;
    this.group.add(mesh);
  }

  #free(region) {
    if (!region.mesh) return;
    this.group.remove(region.mesh);
    region.mesh.geometry.dispose();
    region.mesh = null;
  }

  // Around everything, in the map's own axes; empty without surface.
  get box() {
    const all = new Box3();
    for (const chunk of this.#chunks.values()) if (chunk.box) all.union(chunk.box);
    return all;
  }

  // The chunks whose surface touches a box, in the map's axes: {key, version, places: metres, three a vertex, indices}.
  chunks_in(box) {
    const found = [];
    for (const [key, { arrays, box: own, version, corner }] of this.#chunks) {
      if (!arrays || !own.intersectsBox(box)) continue;
      const scale = this.#block_size_m / kUnitsPerBlock;
      const places = new Float32Array((arrays.places.length / 4) * 3);
      for (let i = 0; 4 * i < arrays.places.length; ++i) {
        for (let k = 0; k < 3; ++k) places[3 * i + k] = arrays.places[4 * i + k] * scale + corner[k] * this.#block_size_m;
      }
      found.push({ key, version, places, indices: arrays.indices });
    }
    return found;
  }

  // From which direction around `up` most of the surface shows its front: a unit vector across `up`, in the map's axes.
  best_side(up) {
    const other = Math.abs(up.x) < 0.7 ? new Vector3(1, 0, 0) : new Vector3(0, 1, 0);
    const east = other.cross(up).normalize();
    const north = up.clone().cross(east);
    const directions = Array.from({ length: kNormalBins }, (_, i) => {
      const turn = (2 * Math.PI * i) / kNormalBins;
      return east.clone().multiplyScalar(Math.cos(turn)).addScaledVector(north, Math.sin(turn));
    });
    const seen = directions.map(() => 0);
    for (const { arrays } of this.#chunks.values()) {
      const normals = arrays?.normals ?? [];
      for (let i = 0; i < normals.length; i += 4 * kNormalStride) {
        directions.forEach((d, k) => { seen[k] += Math.max(0, d.x * normals[i] + d.y * normals[i + 1] + d.z * normals[i + 2]); });
      }
    }
    return directions[seen.indexOf(Math.max(...seen))];
  }
}
