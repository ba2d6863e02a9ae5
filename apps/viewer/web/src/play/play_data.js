// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Fetches what Play needs. What is not there comes as an Error whose message is the server's reason.
import { bytes_of, json_of, picture_of } from '../server.js';

export async function fetch_plan() {
  const affordances = await json_of('/api/play/affordances.json');
  const [navmesh, walls, walls_index] = await Promise.all([bytes_of('/api/play/navmesh.bin'), bytes_of('/api/play/walls.bin'), json_of('/api/play/walls.json')]);
  return { affordances, navmesh, walls, walls_index, world_from_grid: affordances.world_from_grid };
}

export const fetch_frames = async () => (await json_of('/api/play/frames.json')).frames;

export async function fetch_frame(place) {
  const about = await json_of(`/api/play/frame.json?n=${place}`);
  return { ...about, image: await picture_of(`/api/play/frame.jpg?n=${place}`) };
}
