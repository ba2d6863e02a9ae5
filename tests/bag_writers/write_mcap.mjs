// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// node write_mcap.mjs FILE none|lz4|zstd indexed|plain: messages from the standard input, a line of JSON each, by @mcap/core.
import { spawnSync } from "node:child_process";
import { closeSync, openSync, readFileSync, writeSync } from "node:fs";
import { McapWriter } from "@mcap/core";

const [file, compression, form] = process.argv.slice(2);
const descriptor = openSync(file, "w");
let written = 0n;
const writable = {
  position: () => written,
  async write(bytes) {
    writeSync(descriptor, bytes);
    written += BigInt(bytes.byteLength);
  },
};

function packed(bytes) {
  const { stdout, status } = spawnSync(compression, ["-c"], { input: bytes, maxBuffer: 1 << 30 });
  if (status !== 0) throw new Error(`${compression} failed`);
  return stdout;
}

const writer = new McapWriter({
  writable,
  chunkSize: 30000,
  useMessageIndex: form === "indexed",
  useChunkIndex: form === "indexed",
  repeatSchemas: form === "indexed",
  repeatChannels: form === "indexed",
  compressChunk: compression === "none" ? undefined : (bytes) => ({ compression, compressedData: packed(bytes) }),
});
await writer.start({ profile: "ros2", library: "test" });
const channels = new Map();
for (const line of readFileSync(0, "utf8").split("\n")) {
  const { topic, type, time, data } = JSON.parse(line);
  if (!channels.has(topic)) {
    const schemaId = await writer.registerSchema({ name: type, encoding: "ros2msg", data: new Uint8Array() });
    channels.set(topic, await writer.registerChannel({ topic, schemaId, messageEncoding: "cdr", metadata: new Map() }));
  }
  const stamp = BigInt(time);
  await writer.addMessage({ channelId: channels.get(topic), sequence: 0, logTime: stamp, publishTime: stamp, data: Buffer.from(data, "base64") });
}
await writer.end();
closeSync(descriptor);
