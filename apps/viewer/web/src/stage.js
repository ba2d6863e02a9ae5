// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Where things are drawn: renderer, camera, and the group `map` that turns the recording's axes so that Y is up. Draws only when
// something asked for it, and never before the last picture is finished: mapping runs on the same machine, without a graphics card
// on the same cores.
import { Color, Group, PerspectiveCamera, Quaternion, Scene, Vector3, WebGLRenderer } from 'three';

const kFieldOfView_deg = 55;
const kMostPixelRatio = 2;
const kSoftware = /swiftshader|llvmpipe|softpipe|software|basic render/i;
const kShareOfTime = { card: 0.3, software: 0.1 };  // what drawing may take for data that arrives; who moves the view gets all
const kSlow_ms = 120;
const kLongestPause_ms = 3000;
const kPoll_ms = 4;
const kSmallestTurn = 1e-4;  // of 1 - cos: below it the map is not turned again

// Turns `up` to +Y. Half a turn has no one axis, and directions near -Y would make the map spin: those are turned over X first.
export function upright(up) {
  const over = new Quaternion();
  if (up.y < 0) over.setFromAxisAngle(new Vector3(1, 0, 0), Math.PI);
  const turned = up.clone().applyQuaternion(over);
  return new Quaternion().setFromUnitVectors(turned, new Vector3(0, 1, 0)).multiply(over);
}

// Is there no graphics card, so that the processor draws? Then smooth edges would double the work.
function draws_in_software() {
  const gl = document.createElement('canvas').getContext('webgl2');
  const names = gl?.getExtension('WEBGL_debug_renderer_info');
  const found = names ? kSoftware.test(gl.getParameter(names.UNMASKED_RENDERER_WEBGL)) : false;
  gl?.getExtension('WEBGL_lose_context')?.loseContext();
  return found;
}

export class Stage {
  scene = new Scene();
  map = new Group();
  camera = new PerspectiveCamera(kFieldOfView_deg, 1, 0.03, 400);
  renderer;
  up = new Vector3(0, 1, 0);
  instead = null;    // (renderer, scene): draws in place of the camera above
  software = false;  // there is no graphics card
  #material;
  #pending = false;
  #later = 0;            // the timer of a drawing that can wait
  #busy = false;         // the last picture is not finished
  #again = false;
  #finished_ms = 0;
  #took_ms = 0;
  #share;
  #tickers = new Set();
  #before = 0;
  #before_draw = [];
  #after_draw = [];
  #until_drawn = [];     // called when the next picture that begins is finished

  constructor(canvas, material) {
    this.#material = material;
    const software = this.software = draws_in_software();
    this.#share = software ? kShareOfTime.software : kShareOfTime.card;
    this.renderer = new WebGLRenderer({ canvas, antialias: !software, powerPreference: 'high-performance' });
    this.renderer.setPixelRatio(software ? 1 : Math.min(window.devicePixelRatio, kMostPixelRatio));
    this.scene.add(this.map);
    new ResizeObserver(() => this.#resize()).observe(canvas.parentElement);
    this.#resize();
  }

  get canvas() {
    return this.renderer.domElement;
  }

  // Drawing once more, only to say what is under the pointer, would be felt.
  get slow() {
    return this.#took_ms > kSlow_ms;
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

  // Called before every drawing: for what is drawn; and after every frame: for what lies above the canvas.
  before_draw(listener) {
    this.#before_draw.push(listener);
  }

  after_draw(listener) {
    this.#after_draw.push(listener);
  }

  // Somebody moved or chose something: as soon as possible.
  invalidate() {
    if (this.#busy) this.#again = true;
    if (this.#pending || this.#busy) return;
    clearTimeout(this.#later);
    this.#later = 0;
    this.#pending = true;
    this.#tell_busy();
    requestAnimationFrame((now_ms) => this.#draw(now_ms));
  }

  // Something arrived: soon, but drawing keeps to its share of the time.
  invalidate_soon() {
    if (this.#pending || this.#later !== 0) return;
    const pause_ms = Math.min(kLongestPause_ms, this.#took_ms * (1 / this.#share - 1));
    const wait_ms = this.#busy ? pause_ms : this.#finished_ms + pause_ms - performance.now();
    this.#later = setTimeout(() => { this.#later = 0; this.invalidate(); }, Math.max(0, wait_ms));
    this.#tell_busy();
  }

  // Resolves when a picture that was begun after this call is finished.
  drawn() {
    this.invalidate();
    return new Promise((resolve) => this.#until_drawn.push(resolve));
  }

  // For those who wait until the picture is what it should be.
  #tell_busy() {
    this.canvas.setAttribute('aria-busy', `${this.#pending || this.#busy || this.#later !== 0}`);
  }

  #draw(now_ms) {
    this.#pending = false;
    if (this.#busy) {
      this.#again = true;
      return;
    }
    const passed_s = Math.min(0.1, Math.max(0, (now_ms - this.#before) / 1000));
    this.#before = now_ms;
    const waiting = this.#until_drawn;
    this.#until_drawn = [];
    for (const ticker of this.#tickers) if (!ticker(passed_s)) this.#tickers.delete(ticker);
    this.draw_now();
    for (const listener of this.#after_draw) listener();
    this.#wait_until_finished(waiting);
    if (this.#tickers.size > 0) this.invalidate();
  }

  #wait_until_finished(waiting) {
    const gl = this.renderer.getContext();
    const fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    if (!fence) {  // the context is lost
      this.#until_drawn.push(...waiting);
      return;
    }
    gl.flush();
    this.#busy = true;
    const began_ms = performance.now();
    const look = () => {
      if (!gl.isContextLost() && gl.clientWaitSync(fence, 0, 0) === gl.TIMEOUT_EXPIRED) return setTimeout(look, kPoll_ms);
      gl.deleteSync(fence);
      this.#busy = false;
      this.#finished_ms = performance.now();
      this.#took_ms = this.#finished_ms - began_ms;
      this.#tell_busy();
      for (const resolve of waiting) resolve();
      if (!this.#again) return null;
      this.#again = false;
      return this.invalidate();
    };
    setTimeout(look, 0);
  }

  draw_now() {
    for (const listener of this.#before_draw) listener();
    this.camera.updateMatrixWorld();
    this.#material.prepare(this.camera.position);
    if (this.instead) this.instead(this.renderer, this.scene);
    else this.renderer.render(this.scene, this.camera);
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
