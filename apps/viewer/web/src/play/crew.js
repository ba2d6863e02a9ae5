// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// All figures and insects of a map, and what they do on their own. Knows nothing of drawing, so that it runs anywhere.
import { Matrix4, Vector3 } from 'three';
import { setRandomSeed } from 'recast-navigation';
import { Actor } from './actor.js';
import { Floor, kStep_s, Mesh } from './ground.js';
import { Insect } from './insect.js';
import { places_of } from './places.js';
import rules from './rules.json' with { type: 'json' };
import { random_of, shape_of } from './shape.js';

const kMostLate_s = 0.25;
const kFarthestWall_m = 2;

const turned = (rows) => new Matrix4().set(...rows.flat());
// From Detour's axes (x, z, -y) to z-up ones, and back.
const kUpFromDetour = new Matrix4().set(1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1);
const kDetourFromUp = kUpFromDetour.clone().invert();

// From a wall's mesh to the figures' frame.
export const figures_from_wall = (grid_from_wall) => kDetourFromUp.clone().multiply(turned(grid_from_wall)).multiply(kUpFromDetour);
export const world_from_figures = (world_from_grid) => turned(world_from_grid).multiply(kUpFromDetour);

export class Crew {
  people = [];   // {actor, shape, number, wait_s}
  insects = [];  // {insect, wall}
  walls = [];    // {mesh, to_figures}
  places;
  floor;
  on_their_own = true;
  time_s = 0;
  #random;
  #late_s = 0;
  #made = 0;
  #world_from_figures;

  // plan: {navmesh, walls, walls_index, affordances}: bytes and objects of the files of the same names.
  constructor(plan, seed = 1) {
    setRandomSeed(seed);
    this.#random = random_of(seed);
    this.#read(plan);
  }

  #read(plan) {
    this.#world_from_figures = world_from_figures(plan.world_from_grid);
    this.floor = new Floor(plan.navmesh);
    this.places = places_of(plan.affordances);
    this.walls = [];
    for (const { offset, bytes, grid_from_wall, polygons } of plan.walls_index.walls) {
      if (polygons > 0) this.walls.push({ mesh: new Mesh(plan.walls.slice(offset, offset + bytes)), to_figures: figures_from_wall(grid_from_wall) });
    }
  }

  // A newer plan of the same map. Everybody stays where they are in the world, as far as its floor, seats and walls allow. Returns
  // {moved: from the frame so far to the new one, aside_m: how far somebody had to be put aside at most}.
  renew(plan) {
    const { floor, walls } = this;
    const before = this.#world_from_figures;
    this.#read(plan);
    const moved = this.#world_from_figures.clone().invert().multiply(before);
    const aside_m = Math.max(0, ...this.people.map(({ actor }) => actor.renew(this.floor, moved, this.places)));
    this.insects = this.insects.filter((item) => this.#renew_insect(item, moved));
    floor.destroy();
    for (const { mesh } of walls) mesh.destroy();
    return { moved, aside_m };
  }

  // To the nearest place on a wall; false if there is none.
  #renew_insect(item, moved) {
    const to_figures = moved.clone().multiply(item.wall.to_figures);
    const place = new Vector3(...item.insect.place).applyMatrix4(to_figures);
    const ahead = new Vector3(Math.sin(item.insect.heading), 0, Math.cos(item.insect.heading)).transformDirection(to_figures);
    let least_m = Infinity;
    for (const wall of this.walls) {
      const from_figures = wall.to_figures.clone().invert();
      const own = place.clone().applyMatrix4(from_figures);
      const at = wall.mesh.nearest(own.toArray(), kFarthestWall_m);
      const off_m = at === null ? Infinity : own.distanceTo(new Vector3(...at));
      if (off_m >= least_m) continue;
      least_m = off_m;
      const { x, z } = ahead.clone().transformDirection(from_figures);
      Object.assign(item, { wall, solid_at: null });
      item.insect.move_to(wall.mesh, at, Math.atan2(x, z));
    }
    return least_m < Infinity;
  }

  // Somewhere on the floor, away from the others; null if there is no room.
  add_person(near = null) {
    let at = near ? this.floor.nearest(near, 0.6) : null;
    for (let i = 0; i < rules.tries && at === null; ++i) {
      const found = this.floor.random();
      const roomy = found && this.#is_roomy(found) && this.people.every(({ actor }) => distance(actor.place, found) > rules.apart_m);
      if (roomy) at = found;
    }
    if (at === null) return null;
    const number = this.#made++;
    const shape = shape_of(rules.heights_m[number % rules.heights_m.length]);
    const actor = new Actor(shape, this.floor, at, { heading: this.#random() * 2 * Math.PI, seed: number });
    const person = { actor, shape, number, wait_s: this.#between(rules.bored_s) };
    this.people.push(person);
    return person;
  }

  // Not on a scrap of floor behind furniture.
  #is_roomy(at) {
    let reached = 0;
    for (let i = 0; i < 6; ++i) {
      const other = this.floor.random();
      if (other && this.floor.way(at, other) !== null) ++reached;
    }
    return reached >= 2;
  }

  add_insect() {
    if (this.walls.length === 0) return null;
    const wall = this.walls[Math.floor(this.#random() * Math.min(rules.insect.walls, this.walls.length))];
    const at = wall.mesh.random();
    if (at === null) return null;
    const made = { insect: new Insect(wall.mesh, at, this.#random), wall };
    this.insects.push(made);
    return made;
  }

  is_free(place) {
    return this.people.every(({ actor }) => !actor.takes(place));
  }

  clear() {
    for (const { actor } of this.people) actor.leave();
    this.people = [];
    this.insects = [];
  }

  #between([low, high]) {
    return low + (high - low) * this.#random();
  }

  #decide(person, passed_s) {
    const { actor } = person;
    if (!['standing', 'sitting', 'lying'].includes(actor.state)) return;
    person.wait_s -= passed_s;
    if (person.wait_s > 0) return;
    person.wait_s = this.#between(rules.bored_s);
    if (actor.state !== 'standing') return void actor.stand();
    const dice = this.#random();
    if (dice < rules.sits_share) return this.#take(person, this.places.seats, (seat) => actor.sit(seat));
    if (dice < rules.sits_share + rules.lies_share) return this.#take(person, this.places.beds, (bed) => actor.lie(bed));
    const to = this.floor.random();
    if (to) actor.go(to);
  }

  // Who stands in somebody's way steps aside, and of two who block each other the one who came later.
  #make_way() {
    this.people.forEach(({ actor }, i) => {
      if (!actor.is_stuck) return;
      this.people.forEach(({ actor: other }, k) => {
        const yields = k !== i && (other.state === 'standing' || (k > i && other.is_stuck));
        if (yields && distance(other.place, actor.place) <= rules.in_the_way_m) this.#step_aside(other, actor.place);
      });
    });
  }

  #step_aside(actor, from) {
    const [least_m, most_m] = rules.aside_m;
    for (let i = 0; i < rules.tries; ++i) {
      const to = this.floor.random();
      if (to && distance(to, actor.place) < most_m && distance(to, from) > least_m && actor.go(to)) return;
    }
  }

  #take(person, places, act) {
    const free = places.filter((place) => this.is_free(place));
    if (free.length === 0) return;
    if (act(free[Math.floor(this.#random() * free.length)])) person.wait_s = this.#between(rules.rests_s);
  }

  // In steps of one length, so that the same calls give the same motion.
  update(passed_s) {
    this.#late_s = Math.min(kMostLate_s, this.#late_s + passed_s);
    for (; this.#late_s >= kStep_s; this.#late_s -= kStep_s) {
      this.time_s += kStep_s;
      if (this.on_their_own) for (const person of this.people) this.#decide(person, kStep_s);
      this.#make_way();
      this.floor.step();
      for (const { actor } of this.people) actor.update(kStep_s);
      for (const { insect } of this.insects) insect.update(kStep_s);
    }
  }

  destroy() {
    this.clear();
    this.floor.destroy();
    for (const { mesh } of this.walls) mesh.destroy();
  }
}

const distance = (a, b) => Math.hypot(a[0] - b[0], a[2] - b[2]);
