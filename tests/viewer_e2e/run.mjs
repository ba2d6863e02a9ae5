// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// node run.mjs PROGRAM FOLDER TESTS: the viewer from outside, as people meet it: the real program, a real browser without a window.
// Simulates a small home, maps it, and runs TESTS, a file beside this one. FOLDER is made anew and keeps the screenshots.
// Exit code: 0 passed, 1 failed, 2 wrong usage, 77 skipped because something is missing (one line says what).
import { spawnSync } from 'node:child_process';
import { existsSync, mkdirSync, rmSync } from 'node:fs';
import { dirname, join, resolve } from 'node:path';
import { fileURLToPath } from 'node:url';

const kSkipped = 77;
const kVoxels = 'map.voxel_size_m=0.04';  // a quarter of the triangles: the browser draws without a graphics card
const here = dirname(fileURLToPath(import.meta.url));
const chromium = process.env.PANOPTIC_CHROMIUM ?? '/usr/bin/chromium';

function skip(why) {
  console.log(`skipped: ${why}`);
  process.exit(kSkipped);
}

function run(program, args) {
  const { status, error } = spawnSync(program, args, { stdio: ['ignore', 'ignore', 'inherit'] });
  if (status !== 0) throw new Error(`${program} ${args.join(' ')}: ${error?.message ?? `exit code ${status}`}`);
}

if (process.argv.length !== 5) {
  console.error('usage: node run.mjs PROGRAM FOLDER TESTS');
  process.exit(2);
}
if (!existsSync(chromium)) skip(`there is no ${chromium}; scripts/setup --packages-only installs it`);
if (!existsSync(join(here, 'node_modules/playwright-core'))) skip('playwright-core is missing; scripts/setup --packages-only fetches it');
if (!existsSync(join(here, '../../apps/viewer/web/dist/index.html'))) skip('the page is not built; scripts/setup builds it');

const program = resolve(process.argv[2]);
const work = resolve(process.argv[3]);
rmSync(work, { recursive: true, force: true });
mkdirSync(join(work, 'screenshots'), { recursive: true });
// Who plays needs floor: a sensor without noise sees enough of it in few frames.
const kPlayed = ['--seed', '5', '--frames', '150', '--noise', 'none', '--predictions', 'oracle'];
const kHomes = {
  'live.test.mjs': kPlayed,
  'play.test.mjs': kPlayed,
  'past.test.mjs': ['--seed', '11', '--frames', '300', '--noise', 'none', '--predictions', 'oracle', '--dynamics', 'busy'],  // a chair is moved
};
const home = kHomes[process.argv[4]] ?? ['--seed', '1', '--frames', '90', '--predictions', 'good'];
run(program, ['simulate', '--rooms', '1', ...home, '-o', join(work, 'home')]);
run(program, ['run', join(work, 'home'), '--predictions', join(work, 'home/predictions'), '--set', kVoxels, '-o', join(work, 'map'), '--map', join(work, 'home.panoptic')]);
const { status } = spawnSync(process.execPath, ['--test', join(here, process.argv[4])], {
  stdio: 'inherit',
  env: { ...process.env, PANOPTIC_PROGRAM: program, PANOPTIC_WORK: work, PANOPTIC_VOXELS: kVoxels, PANOPTIC_CHROMIUM: chromium },
});
process.exit(status ?? 1);
