// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Asks the server, or the files of a saved page (panoptic export-web), which come as scripts: a page opened from a disk may read
// nothing else.
export const saved = globalThis.panoptic_saved ?? null;  // {path: base64}

const kTypes = { json: 'application/json', jpg: 'image/jpeg', png: 'image/png' };

// The saved answer to a path; null if it was not saved.
export function saved_answer(path) {
  const text = saved[path];
  if (text === undefined) return null;
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const [name] = path.split('?');
  return new Response(bytes, { headers: { 'Content-Type': kTypes[name.split('.').at(-1)] ?? 'application/octet-stream' } });
}

const kPlanPatience_ms = 300000;  // the plan and the distances of a large map take a while

// Answers made from the map file: JSON, bytes, and a picture as a texture takes it.
export const json_of = async (path) => (await ask(path, kPlanPatience_ms)).json();
export const bytes_of = async (path) => new Uint8Array(await (await ask(path, kPlanPatience_ms)).arrayBuffer());
export const picture_of = async (path) =>
  createImageBitmap(await (await ask(path, kPlanPatience_ms)).blob(), { imageOrientation: 'flipY', premultiplyAlpha: 'none' });

export async function ask(path, patience_ms) {
  if (saved !== null) {
    const answer = saved_answer(path);
    if (answer === null) throw new Error(saved['/why_not'] ?? 'this page was saved without it');
    return answer;
  }
  const answer = await fetch(path, { signal: AbortSignal.timeout(patience_ms), cache: 'no-store' });
  if (!answer.ok) throw new Error((await answer.text()).trim() || `${path}: ${answer.status}`);
  return answer;
}
