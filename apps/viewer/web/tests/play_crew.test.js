// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { Vector3 } from 'three';
import { Crew } from '../src/play/crew.js';
import { is_inside, meant, places_of } from '../src/play/places.js';
import { joints_of } from '../src/play/skeleton.js';
import { home, kTable } from './home.js';

const plan = await home();
const kStep_s = 1 / 60;

function crew_of(seed = 1) {
  const crew = new Crew(plan, seed);
  crew.on_their_own = false;
  return crew;
}

function until(crew, holds, seconds) {
  for (let i = 0; i < seconds * 60; ++i) {
    crew.update(kStep_s);
    if (holds()) return;
  }
  assert.fail(`not within ${seconds} s: ${crew.people.map(({ actor }) => `${actor.state} at ${actor.place}`)}`);
}

const turn_between = (a, b) => Math.abs(Math.atan2(Math.sin(a - b), Math.cos(a - b)));

test('Crew: a person walks around the table to a seat, and sits facing as the seat does', () => {
  const crew = crew_of();
  const { actor, shape } = crew.add_person([1.2, 0, 1.2]);
  const [seat] = crew.places.seats;
  assert.ok(actor.sit(seat));
  until(crew, () => actor.state === 'sitting', 30);
  const { pelvis } = joints_of(actor.pose, shape, new Vector3(...actor.place), actor.heading);
  assert.ok(Math.hypot(pelvis.x - 4.3, pelvis.z - 1) < 0.05, `${pelvis.toArray()}`);
  assert.ok(turn_between(actor.heading, -Math.PI / 2) < (20 * Math.PI) / 180);
  assert.ok(!crew.is_free(seat));
  actor.go([1, 0, 3.5]);
  until(crew, () => actor.state === 'standing', 30);
  assert.ok(Math.hypot(actor.place[0] - 1, actor.place[2] - 3.5) < 0.1);
  assert.ok(crew.is_free(seat));
});

test('Crew: a person lies down with the head where the bed has its own', () => {
  const crew = crew_of();
  const { actor, shape } = crew.add_person([4, 0, 3]);
  assert.ok(actor.lie(crew.places.beds[0]));
  until(crew, () => actor.state === 'lying', 30);
  const joints = joints_of(actor.pose, shape, new Vector3(...actor.place), actor.heading);
  assert.ok(joints.head.z < joints.pelvis.z - 0.4 && Math.abs(joints.head.x - 0.5) < 0.1, `${joints.head.toArray()}`);
  assert.ok(actor.stand());
  until(crew, () => actor.state === 'standing', 10);
});

test('Crew: nobody walks through the table, a wall or another one in three minutes of their own', () => {
  const crew = crew_of(3);
  crew.on_their_own = true;
  for (let i = 0; i < 5; ++i) assert.ok(crew.add_person());
  let nearest = Infinity;
  const states = new Set();
  for (let i = 0; i < 180 * 60; ++i) {
    crew.update(kStep_s);
    const up = crew.people.map(({ actor }) => actor).filter(({ state }) => { states.add(state); return state === 'standing' || state === 'walking'; });
    for (const { place: [x, y, z] } of up) {
      const beside = [Math.max(0, kTable.low[0] - x, x - kTable.high[0]), Math.max(0, kTable.low[1] - z, z - kTable.high[1])];
      const near_table = Math.hypot(...beside) < 0.17;
      assert.ok(!near_table && x > 0.17 && x < 4.83 && z > 0.17 && z < 3.83 && Math.abs(y) < 0.03, `${[x, y, z]} after ${i} steps`);
    }
    up.forEach((a, k) => up.slice(k + 1).forEach((b) => { nearest = Math.min(nearest, Math.hypot(a.place[0] - b.place[0], a.place[2] - b.place[2])); }));
  }
  assert.ok(nearest > 0.3, `${nearest} m apart`);
  for (const state of ['walking', 'sitting', 'lying']) assert.ok(states.has(state), state);
});

test('Crew: insects stay on their wall', () => {
  const crew = crew_of();
  const { insect, wall } = crew.add_insect();
  const began = [...insect.place];
  let farthest = 0;
  for (let i = 0; i < 60 * 60; ++i) {
    crew.update(kStep_s);
    const at = new Vector3(...insect.place).applyMatrix4(wall.to_figures);
    assert.ok(Math.abs(at.z) < 0.02, `${at.toArray()}`);  // the wall is at y = 0 of the grid
    farthest = Math.max(farthest, Math.hypot(insect.place[0] - began[0], insect.place[2] - began[2]));
  }
  assert.ok(farthest > 0.2, `it went ${farthest} m`);
});

test('Crew: the same seed gives the same minute', () => {
  const places = [0, 1].map(() => {
    const crew = crew_of(5);
    crew.on_their_own = true;
    for (let i = 0; i < 3; ++i) crew.add_person();
    for (let i = 0; i < 60 * 60; ++i) crew.update(kStep_s);
    return crew.people.map(({ actor }) => actor.place);
  });
  assert.deepEqual(places[0], places[1]);
});

test('Places: a click means the seat, the bed, the table top or the floor under it', () => {
  const places = places_of(plan.affordances);
  assert.equal(meant(places, 7, [4.2, 0.45, 1]).kind, 'seat');
  assert.equal(meant(places, 9, [0.5, 0.5, 2]).kind, 'bed');
  assert.equal(meant(places, 10, [2.5, 0.75, 2]).kind, 'table');
  assert.equal(meant(places, 10, [2.5, 0.3, 1.5]).kind, 'nothing');
  assert.equal(meant(places, 2, [1, 0.01, 1]).kind, 'floor');
  assert.equal(meant(places, 7, [4.2, 0.45, 1], () => false).kind, 'nothing');
  assert.ok(is_inside(places.tables[0].polygon, [2.5, 0.75, 2]) && !is_inside(places.tables[0].polygon, [3.5, 0.75, 2]));
});

test('Crew: bytes that are no navigation mesh are refused', () => {
  assert.throws(() => new Crew({ ...plan, navmesh: new Uint8Array(100) }), /no navigation mesh/);
});

// The same home after its frame was turned by `angle` and raised by `up_m`: what a newer plan of a map that grows is like.
function newer({ angle = 0, up_m = 0, seats = plan.affordances.seats } = {}) {
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  const world_from_grid = [[c, -s, 0, 0], [s, c, 0, 0], [0, 0, 1, up_m], [0, 0, 0, 1]];
  return { ...plan, world_from_grid, affordances: { ...plan.affordances, seats, world_from_grid } };
}

test('Crew: on a newer plan who walks goes on, and who sits stays seated, as long as the seat is there', () => {
  const crew = crew_of();
  const [walker, sitter] = [crew.add_person([1.2, 0, 1.2]), crew.add_person([4, 0, 3])];
  const [seat] = crew.places.seats;
  assert.ok(sitter.actor.sit(seat));
  until(crew, () => sitter.actor.state === 'sitting', 30);
  assert.ok(walker.actor.go([1.2, 0, 3.4]));
  crew.update(0.25);
  crew.update(0.25);
  let before = [...walker.actor.place];
  const nearer = plan.affordances.seats.map((one) => ({ ...one, position: one.position.map((value, i) => value + [0.02, 0, 0.01][i]), height_m: one.height_m + 0.01 }));
  for (let i = 0; i < 3; ++i) {
    const { aside_m } = crew.renew(newer({ seats: nearer }));
    assert.ok(aside_m < 0.01);
    assert.deepEqual([walker.actor.state, sitter.actor.state], ['walking', 'sitting']);
    assert.ok(walker.actor.place.every((value, k) => Math.abs(value - before[k]) < 0.01), `${walker.actor.place} and ${before}`);
    for (let k = 0; k < 10; ++k) crew.update(kStep_s);
    assert.ok(Math.hypot(walker.actor.place[0] - before[0], walker.actor.place[2] - before[2]) > 0.1, 'it lost its speed');
    before = [...walker.actor.place];
  }
  assert.ok(Math.abs(sitter.actor.place[0] - 4.32) < 1e-6 && sitter.actor.goal.seat === crew.places.seats[0] && !crew.is_free(crew.places.seats[0]));
  crew.renew(newer({ seats: plan.affordances.seats.slice(1) }));
  until(crew, () => sitter.actor.state === 'standing', 10);
  until(crew, () => walker.actor.state === 'standing', 10);
  assert.ok(Math.hypot(walker.actor.place[0] - 1.2, walker.actor.place[2] - 3.4) < 0.1);
});

test('Crew: when the frame of the plan changes everybody moves by that, and where the floor is gone to the nearest floor', () => {
  const crew = crew_of();
  const { actor } = crew.add_person([2, 0, 0.6]);
  const { insect, wall } = crew.add_insect();
  const before = { person: [...actor.place], heading: actor.heading, insect: new Vector3(...insect.place).applyMatrix4(wall.to_figures) };
  const angle = 0.02;
  const { moved } = crew.renew(newer({ angle, up_m: 0.03 }));
  const at = new Vector3(...before.person).applyMatrix4(moved);
  assert.ok(Math.abs(at.y + 0.03 - before.person[1]) < 1e-9 && Math.hypot(at.x - actor.place[0], at.z - actor.place[2]) < 0.01, `${actor.place}`);
  assert.ok(Math.abs(actor.place[1]) < 0.021, 'it stands on the floor of now');
  assert.ok(Math.abs(turn_between(before.heading, actor.heading) - angle) < 1e-6);
  const [item] = crew.insects;
  const now = new Vector3(...item.insect.place).applyMatrix4(item.wall.to_figures);
  assert.ok(now.distanceTo(before.insect.applyMatrix4(moved)) < 0.12, `${now.toArray()}`);
  const away = newer();
  away.world_from_grid = [[1, 0, 0, 1.5], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]];  // the old place is 1.5 m off, now under the wall
  const { aside_m } = crew.renew(away);
  assert.ok(crew.floor.nearest(actor.place, 0.05) !== null && aside_m < 4);
  crew.renew({ ...newer(), walls_index: { walls: [] } });
  assert.equal(crew.insects.length, 0);
});
