// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Light or dark: as the system says until somebody chooses. The colours themselves are in styles/theme.css.
import { recall, remember } from './settings.js';

const system = window.matchMedia('(prefers-color-scheme: dark)');

export class Theme {
  #listeners = [];

  constructor() {
    system.addEventListener('change', () => this.#apply());
    this.#apply();
  }

  get dark() {
    return recall('theme', system.matches ? 'dark' : 'light') === 'dark';
  }

  // listener({background, accent, path, frustum, box, ghost, moving}): colours for what is drawn on the canvas; called at once, too.
  on_change(listener) {
    this.#listeners.push(listener);
    listener(this.#colors());
  }

  toggle() {
    remember('theme', this.dark ? 'light' : 'dark');
    this.#apply();
  }

  #apply() {
    document.documentElement.dataset.theme = this.dark ? 'dark' : 'light';
    for (const listener of this.#listeners) listener(this.#colors());
  }

  #colors() {
    const style = getComputedStyle(document.documentElement);
    const color = (name) => style.getPropertyValue(name).trim();
    return { background: color('--scene'), accent: color('--mark'), path: color('--path'), frustum: color('--frustum'), box: color('--mark'), ghost: color('--ghost'), moving: color('--moving') };
  }
}
