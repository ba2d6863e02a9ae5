// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A browser without a window, and the viewer's page in it as people use it: by the names of its controls.
import assert from 'node:assert/strict';
import { join } from 'node:path';
import { chromium } from 'playwright-core';
import { decode_png, differing_share } from './png.mjs';
import { work } from './program.mjs';

const kPatience_ms = 60000;

// Software drawing: test machines have no graphics card.
export function launch() {
  return chromium.launch({
    executablePath: process.env.PANOPTIC_CHROMIUM,
    args: ['--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--ignore-gpu-blocklist'],
  });
}

export class Viewer {
  errors = [];
  page;

  static async open(browser, url, options = {}) {
    const viewer = new Viewer();
    const context = await browser.newContext({ viewport: { width: 1280, height: 800 }, colorScheme: 'light', reducedMotion: 'reduce', ...options });
    viewer.page = await context.newPage();
    viewer.page.setDefaultTimeout(kPatience_ms);
    viewer.page.on('console', (message) => { if (message.type() === 'error') viewer.errors.push(message.text()); });
    viewer.page.on('pageerror', (error) => viewer.errors.push(error.message));
    await viewer.page.goto(url);
    return viewer;
  }

  // Closes it, and says what went wrong in it.
  async close() {
    await this.page.context().close();
    return this.errors;
  }

  button(name) {
    return this.page.getByRole('button', { name, exact: true });
  }

  mode(name) {
    return this.page.getByRole('radio', { name, exact: true });
  }

  async state() {
    return this.page.getByRole('status', { name: 'Connection' }).textContent();
  }

  async until_state(state) {
    await this.until(async () => (await this.state()) === state, `the state never became ${state}`);
  }

  async until(holds, otherwise) {
    const until = Date.now() + kPatience_ms;
    while (!(await holds())) {
      if (Date.now() > until) assert.fail(`${otherwise}; the page says: ${await this.state()}, ${(await this.counts()).text}; errors: ${this.errors}`);
      await this.page.waitForTimeout(50);
    }
  }

  async counts() {
    const text = await this.page.getByRole('status', { name: 'Surface' }).textContent();
    const number = (pattern) => Number((pattern.exec(text)?.[1] ?? '0').replaceAll(',', ''));
    return { text, triangles: number(/([\d,]+) triangles/), chunks: number(/([\d,]+) chunks/), waiting: number(/([\d,]+) to come/) };
  }

  async busy() {
    return (await this.page.locator('#surface').getAttribute('aria-busy')) === 'true';
  }

  // Until nothing is lacking and the picture stands still.
  async settle() {
    await this.until(async () => {
      const { triangles, waiting } = await this.counts();
      return triangles > 0 && waiting === 0 && !(await this.busy());
    }, 'the surface never came');
    let before = await this.look();
    await this.until(async () => {
      await this.page.waitForTimeout(150);
      const now = await this.look();
      const still = differing_share(before, now) === 0 && !(await this.busy());
      before = now;
      return still;
    }, 'the picture never stood still');
    return before;
  }

  // The middle of the canvas, without what floats over its edges.
  async look() {
    const box = await this.page.locator('#surface').boundingBox();
    const clip = { x: box.x + 0.1 * box.width, y: box.y + 0.2 * box.height, width: 0.8 * box.width, height: 0.6 * box.height };
    return decode_png(await this.page.screenshot({ clip }));
  }

  // The picture after it became another one than `before`, and stood still.
  async look_after_change(before) {
    await this.until(async () => differing_share(before, await this.look()) > 0.005, 'the picture never changed');
    return this.settle();
  }

  // Keeps what the page looks like for people to see.
  screenshot(name) {
    return this.page.screenshot({ path: join(work, 'screenshots', `${name}.png`) });
  }
}
