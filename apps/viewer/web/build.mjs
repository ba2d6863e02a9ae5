// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// node build.mjs [FOLDER]: makes the page, FOLDER (default: dist/) with index.html and assets/{page.js,page.css,icon.svg,...}.
// play.js is what only the mode "Play" needs, and comes when it is opened; chunk.js is what both need; saved.js is everything.
// The names are fixed because the server compiles a table of them in; it needs nothing else, and the page loads nothing else.
import { mkdir, readFile, writeFile } from 'node:fs/promises';
import { dirname, join, relative, resolve } from 'node:path';
import { fileURLToPath } from 'node:url';
import { build } from 'esbuild';

const source = dirname(fileURLToPath(import.meta.url));
const target = resolve(process.argv[2] ?? join(source, 'dist'));

// A file that stays the same keeps its time: nothing is compiled again because of it.
async function put(name, bytes) {
  const path = join(target, name);
  const before = await readFile(path).catch(() => null);
  if (before === null || Buffer.compare(before, bytes) !== 0) await writeFile(path, bytes);
}

async function bundle(entryPoints, options) {
  const { outputFiles } = await build({
    absWorkingDir: source,
    entryPoints,
    bundle: true,
    write: false,
    outdir: join(target, 'assets'),
    target: ['chrome100', 'firefox115', 'safari16'],
    minify: true,
    legalComments: 'eof',
    logLevel: 'warning',
    ...options,
  });
  for (const { path, contents } of outputFiles) await put(relative(target, path), Buffer.from(contents));
}

await mkdir(join(target, 'assets'), { recursive: true });
await bundle({ page: 'src/main.js' }, { format: 'esm', splitting: true, chunkNames: '[name]' });
// The same as one classic script, for pages that panoptic export-web saves: a browser loads no modules from a disk.
await bundle({ saved: 'src/main.js' }, { format: 'iife', logOverride: { 'empty-import-meta': 'silent' } });
await bundle({ page: 'styles/page.css' }, {});
await put('assets/icon.svg', await readFile(join(source, 'icon.svg')));
await put('index.html', await readFile(join(source, 'index.html')));
