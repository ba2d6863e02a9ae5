// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// node build.mjs [FOLDER]: makes the page, FOLDER (default: dist/) with index.html and assets/{page.js,page.css,icon.svg}.
// The names are fixed because the server compiles a table of them in; it needs nothing else, and the page loads nothing else.
import { copyFile, mkdir } from 'node:fs/promises';
import { dirname, join, resolve } from 'node:path';
import { fileURLToPath } from 'node:url';
import { build } from 'esbuild';

const source = dirname(fileURLToPath(import.meta.url));
const target = resolve(process.argv[2] ?? join(source, 'dist'));

await mkdir(join(target, 'assets'), { recursive: true });
await build({
  absWorkingDir: source,
  entryPoints: { page: 'src/main.js' },
  outdir: join(target, 'assets'),
  bundle: true,
  format: 'esm',
  target: ['chrome100', 'firefox115', 'safari16'],
  minify: true,
  legalComments: 'eof',
  logLevel: 'warning',
});
await build({
  absWorkingDir: source,
  entryPoints: { page: 'styles/page.css' },
  outdir: join(target, 'assets'),
  bundle: true,
  target: ['chrome100', 'firefox115', 'safari16'],
  minify: true,
  logLevel: 'warning',
});
await copyFile(join(source, 'index.html'), join(target, 'index.html'));
await copyFile(join(source, 'icon.svg'), join(target, 'assets/icon.svg'));
