// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A plan of a room of 5 x 4 m with a table in the middle, in the form of the server's answers.
import { exportNavMesh, init } from 'recast-navigation';
import { generateSoloNavMesh } from 'recast-navigation/generators';

const kCell_m = 0.024;
const kIdentity = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]];

export const kTable = { low: [2, 1.5], high: [3, 2.5], top: 0.75 };  // x and z

function box([x0, z0], [x1, z1], y, places, corners) {
  const at = places.length / 3;
  for (const [x, h, z] of [[x0, 0, z0], [x1, 0, z0], [x1, 0, z1], [x0, 0, z1], [x0, y, z0], [x1, y, z0], [x1, y, z1], [x0, y, z1]]) places.push(x, h, z);
  const faces = [[4, 7, 6], [4, 6, 5], [0, 4, 5], [0, 5, 1], [1, 5, 6], [1, 6, 2], [2, 6, 7], [2, 7, 3], [3, 7, 4], [3, 4, 0]];
  for (const face of faces) corners.push(...face.map((corner) => at + corner));
}

function mesh_of(places, corners, radius_m, height_m) {
  const cells = (length_m) => Math.ceil(length_m / kCell_m);
  const { success, navMesh, error } = generateSoloNavMesh(places, corners, { cs: kCell_m, ch: 0.02, walkableRadius: cells(radius_m), walkableHeight: Math.ceil(height_m / 0.02), walkableClimb: 2, maxSimplificationError: 0.6 });
  if (!success) throw new Error(error);
  return exportNavMesh(navMesh);
}

export async function home() {
  await init();
  const places = [0, 0, 0, 5, 0, 0, 5, 0, 4, 0, 0, 4];
  const corners = [0, 3, 2, 0, 2, 1];
  box(kTable.low, kTable.high, kTable.top, places, corners);
  const navmesh = mesh_of(places, corners, 0.2, 1.5);
  const walls = mesh_of([0, 0, 0, 3, 0, 0, 3, 0, 2, 0, 0, 2], [0, 3, 2, 0, 2, 1], 0.02, 0.05);
  // The wall at y = 0 of the grid: its z leads out of it along +y, its y is up.
  const grid_from_wall = [[-1, 0, 0, 4], [0, 0, 1, 0], [0, 1, 0, 2.2], [0, 0, 0, 1]];
  return {
    navmesh, walls, world_from_grid: kIdentity,
    walls_index: { walls: [{ offset: 0, bytes: walls.byteLength, polygons: 1, area_m2: 6, grid_from_wall }] },
    affordances: {
      world_from_grid: kIdentity,
      seats: [{ position: [4.3, -1, 0.45], facing: [-1, 0, 0], height_m: 0.45, object: 7 }, { position: [4.3, -3, 0.42], facing: [0, 1, 0], height_m: 0.42, object: 8 }],
      lying_places: [{ center: [0.5, -2, 0.5], axis: [0, 1, 0], length_m: 2, width_m: 0.9, height_m: 0.5, object: 9, polygon: [[0.05, -3, 0.5], [0.95, -3, 0.5], [0.95, -1, 0.5], [0.05, -1, 0.5]] }],
      table_tops: [{ height_m: kTable.top, object: 10, polygon: [[2, -2.5, 0.75], [3, -2.5, 0.75], [3, -1.5, 0.75], [2, -1.5, 0.75]] }],
    },
  };
}
