// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// node play_cost.mjs PROGRAM HOME SPEED: what it costs a run to be looked at. HOME is a folder of `panoptic simulate`; it is mapped
// online at SPEED (or max) with nobody looking on, with somebody who only asks for plans (a page on another machine), with a page
// on this machine, and with Play open in it. Prints a line of JSON each.
import { mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { setTimeout as pause } from 'node:timers/promises';

const [program_path, home, speed] = process.argv.slice(2);
if (!speed) {
  console.error('usage: node play_cost.mjs PROGRAM HOME SPEED');
  process.exit(2);
}
const work = mkdtempSync(join(tmpdir(), 'panoptic_play_cost_'));
Object.assign(process.env, { PANOPTIC_PROGRAM: program_path, PANOPTIC_WORK: work, PANOPTIC_CHROMIUM: process.env.PANOPTIC_CHROMIUM ?? '/usr/bin/chromium' });
const { json_of, Program } = await import('./program.mjs');
const { launch, Viewer } = await import('./browser.mjs');

async function ask_for_plans(program, plans) {
  const { origin } = new URL(await program.url());
  for (let seen = 0; program.running; await pause(1000)) {
    try {
      const { revision } = await (await fetch(`${origin}/api/play/plan.json`)).json();
      if (revision !== seen) plans.add(seen = revision);
      await (await fetch(`${origin}/api/play/navmesh.bin?r=${revision}`)).arrayBuffer();
    } catch {
      return;  // the run is over
    }
  }
}

async function look(program, browser, plans, playing) {
  const viewer = await Viewer.open(browser, await program.url());
  if (playing) await viewer.button('Play').click();
  for (; program.running && (await viewer.state()) !== 'Finished'; await pause(500)) {
    const revision = await viewer.page.evaluate(() => globalThis.panoptic_play?.log().plan.revision ?? 0);
    if (revision > 0) plans.add(revision);
  }
  await viewer.close();
}

async function cost_of(mode, browser) {
  const program = new Program(['run', home, '--predictions', join(home, 'predictions'), '-o', join(work, mode), '--online', '--speed', speed,
    ...(mode === 'nobody' ? [] : ['--view', '--port', '0'])]);
  const plans = new Set();
  if (mode === 'plans') await ask_for_plans(program, plans);
  if (mode === 'page' || mode === 'play') await look(program, browser, plans, mode === 'play');
  await program.ended();
  const { online } = json_of(work, mode, 'report.json');
  const { used, dropped, geometry_hz, label_hz, latency } = online;
  return { mode, used, dropped, geometry_hz, label_hz, fused_p95_ms: latency.fused.p95_ms, plans: plans.size };
}

const browser = await launch();
for (const mode of ['nobody', 'plans', 'page', 'play']) console.log(JSON.stringify(await cost_of(mode, browser)));
await browser.close();
rmSync(work, { recursive: true });
