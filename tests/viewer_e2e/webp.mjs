// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Several WebP pictures of one size as one animation: the pictures' own data in the container's frames.

function chunk(name, body) {
  const head = Buffer.alloc(8);
  head.write(name, 0, 'latin1');
  head.writeUInt32LE(body.length, 4);
  return Buffer.concat([head, body, Buffer.alloc(body.length % 2)]);
}

// The data chunks (VP8, VP8L, ALPH) of a still picture.
function picture_data(file) {
  const found = [];
  for (let at = 12; at + 8 <= file.length;) {
    const length = file.readUInt32LE(at + 4);
    const name = file.toString('latin1', at, at + 4);
    if (['VP8 ', 'VP8L', 'ALPH'].includes(name)) found.push(chunk(name, file.subarray(at + 8, at + 8 + length)));
    at += 8 + length + (length % 2);
  }
  return Buffer.concat(found);
}

export function animation(files, { width, height, frame_ms }) {
  const size = Buffer.alloc(10);
  size[0] = 0x02;  // it moves
  size.writeUIntLE(width - 1, 4, 3);
  size.writeUIntLE(height - 1, 7, 3);
  const frames = files.map((file) => {
    const head = Buffer.alloc(16);
    head.writeUIntLE(width - 1, 6, 3);
    head.writeUIntLE(height - 1, 9, 3);
    head.writeUIntLE(frame_ms, 12, 3);
    head[15] = 0x02;  // in place of the one before
    return chunk('ANMF', Buffer.concat([head, picture_data(file)]));
  });
  const body = Buffer.concat([Buffer.from('WEBP'), chunk('VP8X', size), chunk('ANIM', Buffer.alloc(6)), ...frames]);
  return chunk('RIFF', body);
}
