// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Where things are drawn: renderer, camera, and the group `map` that turns the recording's axes so that Y is up. Draws only when
// something asked for it: mapping runs on the same machine, often on the same cores.
import { Color, Group, PerspectiveCamera, Quaternion, Scene, Vector3, WebGLRenderer } from 'three';

const kFieldOfView_deg = 55;
const kMostPixelRatio = 2;
const kSmallestTurn = 1e-4;  // of 1 - cos: below it the map is not turned again

// Turns `up` to +Y. Half a turn has no one axis, and directions near -Y would make the map spin: those are turned over X first.
export function upright(up) {
  const over = new Quaternion();
  if (up.y < 0) over.setFromAxisAngle(new Vector3(1, 0, 0), Math.PI);
  const turned = up.clone().applyQuaternion(over);
  return new Quaternion().setFromUnitVectors(turned, new Vector3(0, 1, 0)).multiply(over);
}

export class Stage {
  scene = new Scene();
  map = new Group();
  camera = new PerspectiveCamera(kFieldOfView_deg, 1, 0.03, 400);
  renderer;
  up = new Vector3(0, 1, 0);
  frames_drawn = 0;
  #material;
  #pending = false;
  #tickers = new Set();
  #before = 0;
  #after_draw = [];

  constructor(canvas, material) {
    this.#material = material;
    this.renderer = new WebGLRenderer({ canvas, antialias: true, powerPreference: 'high-performance' });
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, kMostPixelRatio));
    this.scene.add(this.map);
    new ResizeObserver(() => this.#resize()).observe(canvas.parentElement);
    canvas.addEventListener('webglcontextrestored', () => this.invalidate());
    this.#resize();
  }

  get canvas() {
    return this.renderer.domElement;
  }

  set_background(hex) {
    this.scene.background = new Color(hex);
    this.invalidate();
  }

  // Returns whether the map was turned.
  set_up(up) {
    const next = new Vector3(...up).normalize();
    if (!(next.lengthSq() > 0.5) || 1 - next.dot(this.up) < kSmallestTurn) return false;
    this.up = next;
    this.map.quaternion.copy(upright(next));
    this.map.updateMatrixWorld(true);
    this.invalidate();
    return true;
  }

  // Called before every frame with the seconds since the last one, for as long as it returns true.
  animate(ticker) {
    this.#tickers.add(ticker);
    this.invalidate();
  }

  // Called after every frame: for what lies above the canvas.
  after_draw(listener) {
    this.#after_draw.push(listener);
  }

  invalidate() {
    if (this.#pending) return;
    this.#pending = true;
    requestAnimationFrame((now_ms) => this.#draw(now_ms));
  }

  #draw(now_ms) {
    this.#pending = false;
    const passed_s = Math.min(0.1, Math.max(0, (now_ms - this.#before) / 1000));
    this.#before = now_ms;
    for (const ticker of this.#tickers) if (!ticker(passed_s)) this.#tickers.delete(ticker);
    this.draw_now();
    for (const listener of this.#after_draw) listener();
    if (this.#tickers.size > 0) this.invalidate();
  }

  draw_now() {
    this.camera.updateMatrixWorld();
    this.#material.prepare(this.camera.position);
    this.renderer.render(this.scene, this.camera);
    ++this.frames_drawn;
  }

  // Pixels on the page of a place in the scene, or null behind the eye.
  project(place) {
    const seen = place.clone().project(this.camera);
    if (seen.z > 1 || Math.abs(seen.x) > 1.1 || Math.abs(seen.y) > 1.1) return null;
    return { x: ((seen.x + 1) / 2) * this.canvas.clientWidth, y: ((1 - seen.y) / 2) * this.canvas.clientHeight };
  }

  // The drawing buffer is only sure to be full in the same turn as the drawing.
  screenshot() {
    this.draw_now();
    return new Promise((resolve) => this.canvas.toBlob(resolve, 'image/png'));
  }

  #resize() {
    const { clientWidth: width, clientHeight: height } = this.canvas.parentElement;
    if (width === 0 || height === 0) return;
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.#draw(performance.now());  // at once: a resized canvas is empty
  }
}
