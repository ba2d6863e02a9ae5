// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Mouse and touch on the canvas: a click selects, a double click chooses the point to turn around, resting shows a name.
import { by_id, set_text } from './dom.js';

const kStill_px = 5;   // a press that moves farther is a drag
const kRest_ms = 90;   // picking draws the map once more: only when the pointer rests

export class Pointer {
  #stage;
  #picking;
  #actions;
  #down = null;
  #rest = 0;
  #tooltip = by_id('tooltip');

  // actions: {click(at, event, pick), pivot(place), hover(id) -> name, walking()}
  constructor(stage, picking, actions) {
    this.#stage = stage;
    this.#picking = picking;
    this.#actions = actions;
    const { canvas } = stage;
    canvas.addEventListener('pointerdown', (event) => { this.#down = event.button === 0 ? this.#at(event) : null; this.#leave(); });
    canvas.addEventListener('pointerup', (event) => this.#on_up(event));
    canvas.addEventListener('pointermove', (event) => this.#on_move(event));
    canvas.addEventListener('pointerleave', () => this.#leave());
    canvas.addEventListener('dblclick', (event) => this.#on_double(event));
  }

  #at(event) {
    const box = this.#stage.canvas.getBoundingClientRect();
    if (document.pointerLockElement) return { x: box.width / 2, y: box.height / 2 };  // the crosshair
    return { x: event.clientX - box.left, y: event.clientY - box.top };
  }

  #on_up(event) {
    const at = this.#at(event);
    const still = this.#down && Math.hypot(at.x - this.#down.x, at.y - this.#down.y) <= kStill_px;
    this.#down = null;
    if (still) this.#actions.click(at, event);
  }

  #on_double(event) {
    if (this.#actions.walking() || this.#stage.instead) return;
    const at = this.#at(event);
    const found = this.#picking.at(at.x, at.y);
    if (found) this.#actions.pivot(found.place);
  }

  #on_move(event) {
    clearTimeout(this.#rest);
    if (event.buttons !== 0 || event.pointerType === 'touch' || this.#stage.slow) return this.#leave();
    const at = this.#at(event);
    this.#rest = setTimeout(() => this.#on_rest(at), kRest_ms);
  }

  #on_rest(at) {
    if (this.#stage.instead) return;
    const name = this.#actions.hover(this.#picking.at(at.x, at.y)?.id ?? 0);
    this.#tooltip.hidden = name === '';
    set_text(this.#tooltip, name);
    this.#tooltip.style.transform = `translate(${at.x + 14}px, ${at.y + 14}px)`;
  }

  #leave() {
    clearTimeout(this.#rest);
    this.#tooltip.hidden = true;
    this.#actions.hover(0);
  }
}
