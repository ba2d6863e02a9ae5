// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Fetches what Play needs. What is not there comes as an Error whose message is the server's reason.
import { bytes_of, json_of, picture_of } from '../server.js';

// which: '' of a finished map, '?r=REVISION' of one that grows.
export async function fetch_plan(which = '') {
  const affordances = await json_of(`/api/play/affordances.json${which}`);
  const [navmesh, walls, walls_index] = await Promise.all([bytes_of(`/api/play/navmesh.bin${which}`), bytes_of(`/api/play/walls.bin${which}`), json_of(`/api/play/walls.json${which}`)]);
  return { affordances, navmesh, walls, walls_index, world_from_grid: affordances.world_from_grid };
}

// {revision: of the newest plan, 0: none, looked_at, finished, why_not}
export const fetch_newest = () => json_of('/api/play/plan.json');

export const fetch_frames = async () => (await json_of('/api/play/frames.json')).frames;

export async function fetch_frame(place) {
  const about = await json_of(`/api/play/frame.json?n=${place}`);
  return { ...about, image: await picture_of(`/api/play/frame.jpg?n=${place}`) };
}
