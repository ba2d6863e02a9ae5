// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// First person: W A S D to go, E and Q up and down, Shift faster; the mouse looks around, locked after a click, else while dragging.
import { Euler, Vector3 } from 'three';

const kSpeed_m_s = 1.4;
const kFaster = 3;
const kTurn_rad_px = 0.0024;
const kSteepest_rad = 1.5;
const kMoves = {
  KeyW: [0, 0, -1], ArrowUp: [0, 0, -1], KeyS: [0, 0, 1], ArrowDown: [0, 0, 1],
  KeyA: [-1, 0, 0], ArrowLeft: [-1, 0, 0], KeyD: [1, 0, 0], ArrowRight: [1, 0, 0],
  KeyE: [0, 1, 0], KeyQ: [0, -1, 0],
};

export class Walk {
  #stage;
  #on_move;
  #enabled = false;
  #held = new Set();
  #fast = false;
  #look = new Euler(0, 0, 0, 'YXZ');
  #dragging = false;

  constructor(stage, on_move) {
    this.#stage = stage;
    this.#on_move = on_move;
    const { canvas } = stage;
    window.addEventListener('keydown', (event) => this.#on_key(event, true));
    window.addEventListener('keyup', (event) => this.#on_key(event, false));
    window.addEventListener('blur', () => this.#held.clear());
    canvas.addEventListener('pointerdown', () => { this.#dragging = this.#enabled; });
    window.addEventListener('pointerup', () => { this.#dragging = false; });
    window.addEventListener('pointermove', (event) => this.#on_pointer(event));
    canvas.addEventListener('dblclick', () => this.#lock());
  }

  get locked() {
    return document.pointerLockElement === this.#stage.canvas;
  }

  enable(enabled) {
    this.#enabled = enabled;
    this.#held.clear();
    if (!enabled) {
      if (this.locked) document.exitPointerLock();
      return;
    }
    this.#look.setFromQuaternion(this.#stage.camera.quaternion);
    this.#look.z = 0;
    this.#turn(0, 0);
    this.#stage.canvas.focus({ preventScroll: true });
    this.#lock();
  }

  // Refused on touch screens, and after Escape for a moment: then one looks around by dragging.
  async #lock() {
    if (!this.#enabled || this.locked || !this.#stage.canvas.requestPointerLock) return;
    try {
      await this.#stage.canvas.requestPointerLock();
    } catch {
      this.#dragging = false;
    }
  }

  #on_key(event, down) {
    if (!this.#enabled || event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.target instanceof HTMLInputElement) return;
    this.#fast = event.shiftKey;
    if (!(event.code in kMoves)) return;
    event.preventDefault();
    const idle = this.#held.size === 0;
    down ? this.#held.add(event.code) : this.#held.delete(event.code);
    if (idle && down) this.#stage.animate((passed_s) => this.#go(passed_s));
  }

  #go(passed_s) {
    if (!this.#enabled || this.#held.size === 0) return false;
    const step = new Vector3();
    for (const code of this.#held) step.add(new Vector3(...kMoves[code]));
    step.normalize().multiplyScalar(kSpeed_m_s * (this.#fast ? kFaster : 1) * passed_s);
    step.applyEuler(new Euler(0, this.#look.y, 0));  // along the floor, wherever one looks
    this.#stage.camera.position.add(step);
    this.#on_move();
    return true;
  }

  #on_pointer(event) {
    if (this.#enabled && (this.locked || this.#dragging)) this.#turn(event.movementX, event.movementY);
  }

  #turn(right_px, down_px) {
    this.#look.y -= right_px * kTurn_rad_px;
    this.#look.x = Math.min(kSteepest_rad, Math.max(-kSteepest_rad, this.#look.x - down_px * kTurn_rad_px));
    this.#stage.camera.quaternion.setFromEuler(this.#look);
    this.#stage.invalidate();
  }
}
