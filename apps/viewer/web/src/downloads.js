// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Files that people take with them.
import { notify } from './status.js';

// A name that every file system takes.
export function file_name(title) {
  return title.replace(/[^\p{L}\p{N}._-]+/gu, '_').replace(/^[._]+/, '').slice(0, 80) || 'map';
}

function save(address, name) {
  const link = document.createElement('a');
  link.href = address;
  link.download = name;
  link.click();
}

// The view as it is now, without the panels.
export async function save_screenshot(stage, title, frame_index) {
  save_picture(await stage.screenshot(), title, frame_index);
}

export function save_picture(picture, title, frame_index) {
  if (!picture) return notify('The browser could not make the picture.');
  const address = URL.createObjectURL(picture);
  const number = frame_index < 0 ? '' : `_${`${frame_index}`.padStart(6, '0')}`;
  save(address, `${file_name(title)}${number}.png`);
  setTimeout(() => URL.revokeObjectURL(address), 10000);
}

export function save_glb(title) {
  save('/api/scene.glb', `${file_name(title)}.glb`);
}
