// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Fetches what Play needs. What is not there comes as an Error whose message is the server's reason.
import { ask } from '../server.js';

const kPatience_ms = 300000;  // a plan of a large map takes a while

const bytes_of = async (path) => new Uint8Array(await (await ask(path, kPatience_ms)).arrayBuffer());
const json_of = async (path) => (await ask(path, kPatience_ms)).json();

export async function fetch_plan() {
  const affordances = await json_of('/api/play/affordances.json');
  const [navmesh, walls, walls_index] = await Promise.all([bytes_of('/api/play/navmesh.bin'), bytes_of('/api/play/walls.bin'), json_of('/api/play/walls.json')]);
  return { affordances, navmesh, walls, walls_index, world_from_grid: affordances.world_from_grid };
}

export const fetch_frames = async () => (await json_of('/api/play/frames.json')).frames;

export async function fetch_frame(place) {
  const about = await json_of(`/api/play/frame.json?n=${place}`);
  const picture = await (await ask(`/api/play/frame.jpg?n=${place}`, kPatience_ms)).blob();
  return { ...about, image: await createImageBitmap(picture, { imageOrientation: 'flipY' }) };
}
