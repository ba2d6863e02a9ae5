// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Panels: dragging their borders (or arrow keys on them), tabs, and drawers on narrow screens.
import { by_id } from './dom.js';
import { recall, remember } from './settings.js';

const kPanels = {
  left: { property: '--left', smallest: 190, largest: 520, usual: 270, axis: 'x', sign: 1 },
  right: { property: '--right', smallest: 220, largest: 640, usual: 320, axis: 'x', sign: -1 },
  bottom: { property: '--bottom', smallest: 0, largest: 420, usual: 132, axis: 'y', sign: -1 },
};
const kKeyStep_px = 24;

function resizable(name) {
  const panel = kPanels[name];
  const handle = by_id(`resize-${name}`);
  let size = recall(`size.${name}`, panel.usual);
  const apply = (next) => {
    size = Math.round(Math.min(panel.largest, Math.max(panel.smallest, next)));
    document.documentElement.style.setProperty(panel.property, `${size}px`);
    handle.setAttribute('aria-valuenow', `${size}`);
    remember(`size.${name}`, size);
  };
  handle.setAttribute('aria-valuemin', `${panel.smallest}`);
  handle.setAttribute('aria-valuemax', `${panel.largest}`);
  handle.addEventListener('pointerdown', (down) => {
    const start = size;
    handle.setPointerCapture(down.pointerId);
    handle.onpointermove = (move) => apply(start + panel.sign * (panel.axis === 'x' ? move.clientX - down.clientX : move.clientY - down.clientY));
    handle.onpointerup = () => { handle.onpointermove = null; };
    down.preventDefault();
  });
  handle.addEventListener('dblclick', () => apply(panel.usual));
  handle.addEventListener('keydown', (event) => {
    const step = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
    if (!step) return;
    apply(size + panel.sign * kKeyStep_px * (panel.axis === 'x' ? step[0] : step[1]));
    event.preventDefault();
  });
  apply(size);
}

function drawer(side) {
  const button = by_id(`toggle-${side}`);
  const show = (open) => {
    document.body.classList.toggle(`${side}-open`, open);
    button.setAttribute('aria-expanded', `${open}`);
  };
  button.addEventListener('click', () => show(!document.body.classList.contains(`${side}-open`)));
  by_id('surface').addEventListener('pointerdown', () => show(false));
  show(false);
}

export class Tabs {
  #tabs;

  constructor(list) {
    this.#tabs = [...list.querySelectorAll('[role=tab]')];
    for (const tab of this.#tabs) tab.addEventListener('click', () => this.open(tab.id));
    list.addEventListener('keydown', (event) => {
      const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
      if (!step) return;
      const at = this.#tabs.findIndex((tab) => tab.getAttribute('aria-selected') === 'true');
      const next = this.#tabs[(at + step + this.#tabs.length) % this.#tabs.length];
      this.open(next.id);
      next.focus();
    });
  }

  open(id) {
    for (const tab of this.#tabs) {
      const chosen = tab.id === id;
      tab.setAttribute('aria-selected', `${chosen}`);
      tab.tabIndex = chosen ? 0 : -1;
      by_id(tab.getAttribute('aria-controls')).hidden = !chosen;
    }
  }
}

export function lay_out() {
  for (const name of Object.keys(kPanels)) resizable(name);
  drawer('left');
  drawer('right');
}
