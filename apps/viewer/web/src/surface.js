// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The chunks of the surface as three.js meshes: one per block, replaced when a newer version arrives, freed at once. Blocks out of
// view are left out by three.js, which has a sphere for each of them.
import { Box3, BufferAttribute, BufferGeometry, Group, Mesh, Sphere, Vector3 } from 'three';
import { decode_chunk, kUnitsPerBlock } from './protocol.js';
import { kIds } from './labels.js';

const kNormalBins = 16;

function geometry_of(arrays, { low, high }) {
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(arrays.places, 4));
  geometry.setAttribute('normal', new BufferAttribute(arrays.normals, 4, true));
  geometry.setAttribute('color', new BufferAttribute(arrays.colors, 4, true));
  geometry.setIndex(new BufferAttribute(arrays.indices, 1));
  const center = [0, 1, 2].map((k) => (low[k] + high[k]) / 2);
  geometry.boundingSphere = new Sphere(new Vector3(...center), Math.hypot(...[0, 1, 2].map((k) => high[k] - low[k])) / 2);
  return geometry;
}

function extent_of(places) {
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  for (let i = 0; i < places.length; i += 4) {
    for (let k = 0; k < 3; ++k) {
      low[k] = Math.min(low[k], places[i + k]);
      high[k] = Math.max(high[k], places[i + k]);
    }
  }
  return { low, high };
}

export class Surface {
  group = new Group();
  vertices_of = new Uint32Array(kIds);  // by panoptic id; borders of chunks count twice
  vertices = 0;
  triangles = 0;
  #chunks = new Map();  // key -> {version, mesh or null, vertices, triangles, ids, extent}
  #material;
  #decoder;
  #block_size_m = 1;

  constructor(material, decoder) {
    this.#material = material;
    this.#decoder = decoder;
  }

  get chunk_count() {
    return [...this.#chunks.values()].filter((chunk) => chunk.mesh !== null).length;
  }

  reset(scene) {
    for (const chunk of this.#chunks.values()) this.#forget(chunk);
    this.#chunks.clear();
    this.#block_size_m = scene.block_size_m;
  }

  // Answers may overtake each other: an older version never replaces a newer one.
  put(encoded) {
    const before = this.#chunks.get(encoded.key);
    if (before && before.version >= encoded.version) return;
    const chunk = this.#made(encoded);
    if (before) this.#forget(before);
    this.#chunks.set(encoded.key, chunk);
    this.vertices += chunk.vertices;
    this.triangles += chunk.triangles;
    for (const [id, count] of chunk.ids) this.vertices_of[id] += count;
    if (chunk.mesh) this.group.add(chunk.mesh);
  }

  #made(encoded) {
    const { version, vertices, triangles } = encoded;
    const chunk = { version, vertices, triangles, ids: new Map(), mesh: null, box: null };
    if (triangles === 0) return chunk;
    const arrays = decode_chunk(encoded, this.#decoder);
    for (let i = 3; i < arrays.places.length; i += 4) chunk.ids.set(arrays.places[i], (chunk.ids.get(arrays.places[i]) ?? 0) + 1);
    const { low, high } = extent_of(arrays.places);
    const scale = this.#block_size_m / kUnitsPerBlock;
    const corner = new Vector3(encoded.x, encoded.y, encoded.z).multiplyScalar(this.#block_size_m);
    chunk.box = new Box3(new Vector3(...low).multiplyScalar(scale).add(corner), new Vector3(...high).multiplyScalar(scale).add(corner));
    chunk.mesh = new Mesh(geometry_of(arrays, { low, high }), this.#material.seen);
    chunk.mesh.position.copy(corner);
    chunk.mesh.scale.setScalar(scale);
    chunk.mesh.updateMatrix();
    chunk.mesh.matrixAutoUpdate = false;
    return chunk;
  }

  #forget(chunk) {
    this.vertices -= chunk.vertices;
    this.triangles -= chunk.triangles;
    for (const [id, count] of chunk.ids) this.vertices_of[id] -= count;
    if (!chunk.mesh) return;
    this.group.remove(chunk.mesh);
    chunk.mesh.geometry.dispose();
  }

  // Around everything, in the map's own axes; empty without surface.
  get box() {
    const all = new Box3();
    for (const chunk of this.#chunks.values()) if (chunk.box) all.union(chunk.box);
    return all;
  }

  // From which direction around `up` most of the surface shows its front: a unit vector across `up`, in the map's axes.
  best_side(up) {
    const east = new Vector3(1, 0, 0).cross(up).lengthSq() > 0.1 ? new Vector3(1, 0, 0).cross(up).normalize() : new Vector3(0, 1, 0).cross(up).normalize();
    const north = up.clone().cross(east);
    const directions = Array.from({ length: kNormalBins }, (_, i) => {
      const turn = (2 * Math.PI * i) / kNormalBins;
      return east.clone().multiplyScalar(Math.cos(turn)).addScaledVector(north, Math.sin(turn));
    });
    const seen = directions.map(() => 0);
    for (const { mesh } of this.#chunks.values()) {
      const normals = mesh?.geometry.getAttribute('normal').array ?? [];
      for (let i = 0; i < normals.length; i += 4 * 16) {
        directions.forEach((d, k) => { seen[k] += Math.max(0, d.x * normals[i] + d.y * normals[i + 1] + d.z * normals[i + 2]); });
      }
    }
    return directions[seen.indexOf(Math.max(...seen))];
  }
}
