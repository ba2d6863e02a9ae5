// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Things that stand, tip and fall: the one seam to Rapier as WebAssembly. The surface of the map near the things is solid; it is
// handed over chunk by chunk as it is needed. Coordinates are those of the figures, y is up.
import RAPIER from '@dimforge/rapier3d-compat';
import { Quaternion, Vector3 } from 'three';
import { kThings } from './things.js';

const kStep_s = 1 / 120;
const kMostLate_s = 0.25;
const kMostThings = 40;
const kLost_m = -3;  // below the floor: it fell out of the map

let ready = null;
export const start_physics = () => (ready ??= RAPIER.init());

export class Physics {
  #world = new RAPIER.World({ x: 0, y: -9.81, z: 0 });
  #chunks = new Map();  // key -> {version, collider}
  #things = [];         // {body, kind}
  #walkers = [];
  #late_s = 0;

  constructor() {
    this.#world.timestep = kStep_s;
    // Where the map has no floor, because nobody looked there, nothing falls through.
    this.#world.createCollider(RAPIER.ColliderDesc.cuboid(200, 0.5, 200).setTranslation(0, -0.53, 0));
  }

  // chunks: {key, version, places, indices}, places in the figures' frame.
  solid(chunks) {
    for (const { key, version, places, indices } of chunks) {
      const before = this.#chunks.get(key);
      if (before?.version === version) continue;
      if (before) this.#world.removeCollider(before.collider, false);
      const collider = this.#world.createCollider(RAPIER.ColliderDesc.trimesh(places, Uint32Array.from(indices)).setFriction(0.8));
      this.#chunks.set(key, { version, collider });
    }
  }

  // Nothing of the surface is solid any more, and things are elsewhere: `turn` [x, y, z, w], then `by`. They fall where they are.
  move(turn, by) {
    for (const { collider } of this.#chunks.values()) this.#world.removeCollider(collider, false);
    this.#chunks.clear();
    const rotation = new Quaternion(...turn);
    for (const { body } of this.#things.filter((thing) => thing !== null)) {
      const { x, y, z } = body.translation();
      const place = new Vector3(x, y, z).applyQuaternion(rotation).add(new Vector3(...by));
      const held = body.rotation();
      body.setTranslation(place, true);
      body.setRotation(rotation.clone().multiply(new Quaternion(held.x, held.y, held.z, held.w)), true);
    }
  }

  // Where a ray from [x, y, z] meets the solid surface within so many metres: the distance, or null.
  cast([x, y, z], [dx, dy, dz], far_m) {
    const ray = new RAPIER.Ray({ x, y, z }, { x: dx, y: dy, z: dz });
    const hit = this.#world.castRay(ray, far_m, false, RAPIER.QueryFilterFlags.EXCLUDE_DYNAMIC | RAPIER.QueryFilterFlags.EXCLUDE_KINEMATIC);
    return hit === null ? null : hit.timeOfImpact;
  }

  // A thing that stands at [x, y, z]. Returns its number, or null if there are too many.
  put(kind, [x, y, z], turn = 0) {
    if (this.#things.filter((thing) => thing !== null).length >= kMostThings) return null;
    const { hull, mass_kg } = kThings[kind];
    const body = this.#world.createRigidBody(RAPIER.RigidBodyDesc.dynamic().setTranslation(x, y + 0.004, z)
      .setRotation({ x: 0, y: Math.sin(turn / 2), z: 0, w: Math.cos(turn / 2) }).setCcdEnabled(true).setLinearDamping(0.15).setAngularDamping(0.4));
    hull.forEach(([radius, half, middle], i) => {
      const part = RAPIER.ColliderDesc.cylinder(half, radius).setTranslation(0, middle, 0).setFriction(0.7).setRestitution(0.12).setMass(i === 0 ? mass_kg : 0.12 * mass_kg);
      this.#world.createCollider(part, body);
    });
    this.#things.push({ body, kind });
    return this.#things.length - 1;
  }

  // A push with the speed [x, y, z] m/s near its upper end.
  push(number, [x, y, z]) {
    const { body, kind } = this.#things[number];
    const { mass_kg, hull } = kThings[kind];
    const at = body.translation();
    body.applyImpulseAtPoint({ x: x * mass_kg, y: y * mass_kg, z: z * mass_kg }, { x: at.x, y: at.y + hull[0][2] * 1.15, z: at.z }, true);
  }

  // Where figures are: things give way to them. places: [[x, y, z], ...]
  walkers(places, height_m) {
    while (this.#walkers.length < places.length) {
      const body = this.#world.createRigidBody(RAPIER.RigidBodyDesc.kinematicPositionBased());
      this.#world.createCollider(RAPIER.ColliderDesc.capsule(height_m / 2 - 0.16, 0.16), body);
      this.#walkers.push(body);
    }
    this.#walkers.forEach((body, i) => {
      const [x, y, z] = places[i] ?? [0, -50, 0];
      body.setNextKinematicTranslation({ x, y: y + height_m / 2, z });
    });
  }

  // Returns whether anything moves.
  step(passed_s) {
    this.#late_s = Math.min(kMostLate_s, this.#late_s + passed_s);
    for (; this.#late_s >= kStep_s; this.#late_s -= kStep_s) this.#world.step();
    return this.#things.some((thing) => thing !== null && !thing.body.isSleeping());
  }

  // Makes what was handed over since the last step known to rays.
  settle() {
    this.#world.timestep = 0;
    this.#world.step();
    this.#world.timestep = kStep_s;
  }

  // {kind, place, turn, asleep} of a thing; null if it was taken away or fell out of the map.
  at(number) {
    const thing = this.#things[number];
    if (!thing) return null;
    const { x, y, z } = thing.body.translation();
    if (y < kLost_m) {
      this.remove(number);
      return null;
    }
    const turn = thing.body.rotation();
    return { kind: thing.kind, place: [x, y, z], turn: [turn.x, turn.y, turn.z, turn.w], asleep: thing.body.isSleeping() };
  }

  remove(number) {
    if (this.#things[number]) this.#world.removeRigidBody(this.#things[number].body);
    this.#things[number] = null;
  }

  destroy() {
    this.#world.free();
  }
}
