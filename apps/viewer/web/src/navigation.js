// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// How one moves: around a point (orbit), on foot (walk), or behind the recording's camera (follow). Until somebody touches the
// view it frames the growing map by itself.
import { MathUtils, Quaternion, Vector3 } from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';
import { Walk } from './walk.js';

const kFlight_s = 0.6;
const kElevation = MathUtils.degToRad(38);
const kWorthMoving = 0.04;  // of the distance: the view does not follow every new chunk
const kBehind_m = 0.9;
const kAbove_m = 0.35;
const kFollowRate_hz = 3.5;

const calm = window.matchMedia('(prefers-reduced-motion: reduce)');
const ease = (t) => t * t * (3 - 2 * t);

export class Navigation {
  mode = 'orbit';
  touched = false;
  #stage;
  #surface;
  #orbit;
  #walk;
  #flight = null;
  #recording = null;  // {position, rotation} of the recording's camera in the scene
  #side = null;
  #framed = null;  // where the view was last put by itself
  #chunks_when_sided = 0;
  #listeners = [];

  constructor(stage, surface) {
    this.#stage = stage;
    this.#surface = surface;
    this.#orbit = new OrbitControls(stage.camera, stage.canvas);
    this.#orbit.enableDamping = !calm.matches;
    this.#orbit.dampingFactor = 0.12;
    this.#orbit.zoomToCursor = true;
    this.#orbit.minDistance = 0.08;
    this.#orbit.maxDistance = 150;
    this.#orbit.addEventListener('change', () => (this.touched ? stage.invalidate() : stage.invalidate_soon()));
    this.#orbit.addEventListener('start', () => this.#on_touch());
    stage.canvas.addEventListener('wheel', () => this.#on_touch(), { passive: true });
    stage.canvas.addEventListener('pointermove', (event) => {
      if (event.buttons !== 0 && Math.hypot(event.movementX, event.movementY) > 2) this.#leave_follow();
    });
    this.#walk = new Walk(stage, () => { this.touched = true; });
    stage.camera.position.set(2.5, 2.5, 4);
    this.#orbit.update();
  }

  // listener(mode) after every change of the mode.
  on_mode(listener) {
    this.#listeners.push(listener);
  }

  set_mode(mode) {
    if (mode === this.mode) return;
    const before = this.mode;
    this.mode = mode;
    this.#flight = null;
    this.#orbit.enabled = mode === 'orbit';
    this.#walk.enable(mode === 'walk');
    if (mode === 'orbit' && before !== 'orbit') this.#look_ahead(1.5);
    if (mode === 'follow') this.#stage.animate((passed_s) => this.#follow(passed_s));
    if (mode !== 'orbit') this.touched = true;
    for (const listener of this.#listeners) listener(mode);
  }

  // The pose of the recording's colour camera in the scene: it looks along its +Z, its Y is down.
  set_recording_camera(position, rotation) {
    this.#recording = { position, rotation };
    if (this.mode === 'follow') this.#stage.animate((passed_s) => this.#follow(passed_s));
  }

  reset() {
    if (this.mode !== 'orbit') this.set_mode('orbit');
    this.touched = false;
    this.#side = null;
    this.#framed = null;
    this.frame_map({ at_once: true });
  }

  forget() {
    this.touched = false;
    this.#side = null;
    this.#framed = null;
    this.#recording = null;
  }

  // Shows all of the surface, from where most of it faces the eye; `whole` says that nothing is lacking for the first time.
  frame_map({ at_once = false, whole = false } = {}) {
    const box = this.#surface.box;
    if (box.isEmpty() || this.touched || this.mode !== 'orbit') return;
    if (this.#side === null || whole || this.#surface.chunk_count > 1.5 * this.#chunks_when_sided) {
      this.#side = this.#surface.best_side(this.#stage.up).applyQuaternion(this.#stage.map.quaternion);
      this.#chunks_when_sided = this.#surface.chunk_count;
    }
    const toward = this.#side.clone().multiplyScalar(Math.cos(kElevation)).setY(Math.sin(kElevation)).normalize();
    const goal = this.#goal(box, toward, 0.9);
    if (!at_once && !whole && !this.#is_worth_moving(goal)) return;
    this.#framed = goal;
    if (this.#stage.software && !at_once) this.#jump(goal);
    else this.#start_flight(goal, at_once ? kFlight_s : 1.2);
  }

  #is_worth_moving({ position, target }) {
    const before = this.#framed;
    return !before || before.position.distanceTo(position) + before.target.distanceTo(target) > kWorthMoving * position.distanceTo(target);
  }

  // To the box of an object (in the map's axes), from the side on which the eye is by now.
  fly_to(box) {
    if (this.mode !== 'orbit') this.set_mode('orbit');
    this.touched = true;
    const toward = this.#stage.camera.position.clone().sub(this.#orbit.target);
    toward.y = Math.max(toward.y, 0.35 * Math.hypot(toward.x, toward.z));
    this.#start_flight(this.#goal(box, toward.normalize(), 1.4), kFlight_s);
  }

  // The point that the eye turns around, in the scene.
  set_pivot(place) {
    if (this.mode !== 'orbit') return;
    this.touched = true;
    const move = place.clone().sub(this.#orbit.target);
    this.#start_flight({ target: place, position: this.#stage.camera.position.clone().addScaledVector(move, 0.5) }, kFlight_s);
  }

  #leave_follow() {
    if (this.mode === 'follow') this.set_mode('orbit');
  }

  #on_touch() {
    this.#leave_follow();
    this.touched = true;
    this.#flight = null;
    this.#stage.animate(() => this.mode === 'orbit' && this.#flight === null && this.#orbit.update());
  }

  // From where a box fills the view, `room` times as far away as it needs.
  #goal(box, toward, room) {
    const center = this.#stage.map.localToWorld(box.getCenter(new Vector3()));
    const radius = Math.max(0.12, box.getSize(new Vector3()).length() / 2);
    const camera = this.#stage.camera;
    const half = MathUtils.degToRad(camera.fov / 2);
    const narrow = Math.atan(Math.tan(half) * Math.min(1, camera.aspect));
    const distance = (radius * room) / Math.sin(narrow);
    camera.far = Math.max(100, 20 * radius);
    camera.updateProjectionMatrix();
    return { target: center, position: center.clone().addScaledVector(toward, distance) };
  }

  // From a place of the scene towards another one, at once.
  look(position, target) {
    if (this.mode !== 'orbit') this.set_mode('orbit');
    this.touched = true;
    this.#jump({ target, position });
    this.#stage.camera.updateMatrixWorld();  // a click may come before the next drawing
  }

  #jump({ target, position }) {
    this.#flight = null;
    this.#stage.camera.position.copy(position);
    this.#orbit.target.copy(target);
    this.#orbit.update();
  }

  #start_flight({ target, position }, seconds) {
    const flight = {
      from: this.#stage.camera.position.clone(), to: position, from_target: this.#orbit.target.clone(), to_target: target,
      done: calm.matches ? 1 : 0, seconds,
    };
    this.#flight = flight;
    this.#stage.animate((passed_s) => this.#fly_on(flight, passed_s));
  }

  #fly_on(flight, passed_s) {
    if (this.#flight !== flight) return false;
    flight.done = Math.min(1, flight.done + passed_s / flight.seconds);
    const t = ease(flight.done);
    this.#stage.camera.position.lerpVectors(flight.from, flight.to, t);
    this.#orbit.target.lerpVectors(flight.from_target, flight.to_target, t);
    this.#orbit.update();
    if (flight.done >= 1) this.#flight = null;
    return flight.done < 1;
  }

  #follow(passed_s) {
    if (this.mode !== 'follow' || this.#recording === null) return false;
    const { position, rotation } = this.#recording;
    const ahead = new Vector3(0, 0, 1).applyQuaternion(rotation);
    const goal = position.clone().addScaledVector(ahead, -kBehind_m).add(new Vector3(0, kAbove_m, 0));
    const camera = this.#stage.camera;
    const share = calm.matches ? 1 : 1 - Math.exp(-kFollowRate_hz * passed_s);
    camera.position.lerp(goal, share);
    const looking = camera.clone();
    looking.position.copy(goal);
    looking.lookAt(position.clone().addScaledVector(ahead, 1.2));
    camera.quaternion.slerp(looking.quaternion, share);
    return camera.position.distanceTo(goal) > 0.002 || camera.quaternion.angleTo(looking.quaternion) > 0.002;
  }

  // Goes on turning around what lies ahead, without a jump.
  #look_ahead(distance_m) {
    const camera = this.#stage.camera;
    const ahead = new Vector3(0, 0, -1).applyQuaternion(new Quaternion().copy(camera.quaternion));
    this.#orbit.target.copy(camera.position).addScaledVector(ahead, distance_m);
    this.#orbit.update();
    this.#stage.invalidate();
  }
}
