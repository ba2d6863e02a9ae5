// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// node validate.mjs FILE.glb: checks a glTF file with the Khronos validator and prints every error and warning.
// Exit code: 0 neither errors nor warnings, 1 some, 2 wrong usage, 3 the validator is not installed (`npm ci` in this folder).
import { readFile } from 'node:fs/promises';

const kSeverities = ['error', 'warning'];

async function load_validator() {
  try {
    return await import('gltf-validator');
  } catch {
    console.error('gltf-validator is not installed: run `npm ci` in tools/gltf_validator');
    process.exit(3);
  }
}

if (process.argv.length !== 3) {
  console.error('usage: node validate.mjs FILE.glb');
  process.exit(2);
}
const path = process.argv[2];
const validator = await load_validator();
const bytes = await readFile(path).catch((error) => {
  console.error(`cannot read ${path}: ${error.message}`);
  process.exit(2);
});
try {
  const report = await validator.validateBytes(new Uint8Array(bytes), { uri: path });
  const { numErrors, numWarnings, messages } = report.issues;
  for (const message of messages.filter((m) => m.severity < kSeverities.length)) {
    console.log(`${kSeverities[message.severity]}: ${message.code} at ${message.pointer ?? message.offset}: ${message.message}`);
  }
  console.log(`${path}: ${numErrors} errors, ${numWarnings} warnings`);
  process.exit(numErrors + numWarnings > 0 ? 1 : 0);
} catch (error) {
  console.log(`${path}: not glTF: ${error}`);
  process.exit(1);
}
