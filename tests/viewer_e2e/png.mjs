// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Pixels of the pictures that the browser takes: PNG, 8 bits, RGB or RGBA, not interlaced.
import { inflateSync } from 'node:zlib';

function paeth(a, b, c) {
  const [to_a, to_b, to_c] = [Math.abs(b - c), Math.abs(a - c), Math.abs(a + b - 2 * c)];
  return to_a <= to_b && to_a <= to_c ? a : to_b <= to_c ? b : c;
}

function unfilter(kind, line, above, bytes) {
  for (let i = 0; i < line.length; ++i) {
    const a = i >= bytes ? line[i - bytes] : 0;
    const b = above[i];
    const c = i >= bytes ? above[i - bytes] : 0;
    line[i] += [0, a, b, (a + b) >> 1, paeth(a, b, c)][kind];
  }
}

// {width, height, channels, pixels}
export function decode_png(file) {
  let header = null;
  const data = [];
  for (let at = 8; at < file.length;) {
    const length = file.readUInt32BE(at);
    const kind = file.toString('latin1', at + 4, at + 8);
    const body = file.subarray(at + 8, at + 8 + length);
    if (kind === 'IHDR') header = { width: body.readUInt32BE(0), height: body.readUInt32BE(4), channels: body[9] === 6 ? 4 : 3 };
    if (kind === 'IDAT') data.push(body);
    at += 12 + length;
  }
  const raw = inflateSync(Buffer.concat(data));
  const stride = header.width * header.channels;
  const pixels = new Uint8Array(stride * header.height);
  let above = new Uint8Array(stride);
  for (let y = 0; y < header.height; ++y) {
    const line = pixels.subarray(y * stride, (y + 1) * stride);
    line.set(raw.subarray(y * (stride + 1) + 1, (y + 1) * (stride + 1)));
    unfilter(raw[y * (stride + 1)], line, above, header.channels);
    above = line;
  }
  return { ...header, pixels };
}

// The share of pixels that differ by more than what nobody sees.
export function differing_share(a, b) {
  if (a.width !== b.width || a.height !== b.height) return 1;
  let differing = 0;
  for (let i = 0; i < a.pixels.length; i += a.channels) {
    differing += [0, 1, 2].some((k) => Math.abs(a.pixels[i + k] - b.pixels[i + k]) > 3) ? 1 : 0;
  }
  return differing / (a.width * a.height);
}

// The share of pixels that have about this colour.
export function share_of_color(picture, color) {
  let found = 0;
  for (let i = 0; i < picture.pixels.length; i += picture.channels) {
    found += [0, 1, 2].every((k) => Math.abs(picture.pixels[i + k] - color[k]) <= 3) ? 1 : 0;
  }
  return found / (picture.width * picture.height);
}
