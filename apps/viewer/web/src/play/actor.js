// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// One figure and its doings: it stands, walks, turns, sits, lies. It knows nothing of drawing. While it stands and walks the crowd moves it;
// from the spot before a seat to the seat and back it moves by itself.
import { Vector3 } from 'three';
import { bending, ease, lying, mix, resting, shuffling, sitting, standing, stride_of, walking } from './pose.js';
import { edges_of, spots_before } from './places.js';
import rules from './rules.json' with { type: 'json' };

const kMoving_m_s = 0.06;

const wrapped = (angle) => Math.atan2(Math.sin(angle), Math.cos(angle));
const heading_of = ([x, , z]) => Math.atan2(x, z);
const between = (a, b, t) => a.map((value, i) => value + (b[i] - value) * t);
const apart = (a, b) => Math.hypot(a[0] - b[0], a[2] - b[2]);
const below = ([x, , z]) => [x, 0, z];
const kSamePlace_m = 0.3;               // a seat or bed of a newer plan that is no farther away is the same one
const kFootholds_m = [0.4, 1, 4];       // where the floor of a newer plan is looked for

// The seat or bed of the same object that is there now; undefined if there is none.
const same_place = (all, { object }, at) => all.filter((one) => one.object === object && apart(one.at, at) < kSamePlace_m).sort((a, b) => apart(a.at, at) - apart(b.at, at))[0];

export class Actor {
  state = 'standing';  // walking, turning, sitting down, sitting, lying down, lying, getting up, standing up
  place;               // [x, y, z] on the floor below it
  heading;
  pose;
  goal = null;         // {kind: 'floor' | 'seat' | 'bed', ...} that it goes to, or is on
  #shape;
  #floor;
  #agent;
  #most_m_s;
  #seed;
  #time_s = 0;
  #in_state_s = 0;
  #phase = 0;
  #gait = 0;           // how much of the pose is walking
  #speed = 0;
  #stuck_s = 0;

  #homeless = false;   // the seat or bed that it is on is gone
  #next = null;        // what it was told meanwhile

  constructor(shape, floor, at, { heading = 0, seed = 0 } = {}) {
    this.#shape = shape;
    this.#floor = floor;
    this.#seed = seed;
    this.place = [...at];
    this.heading = heading;
    this.pose = standing(shape);
    const { speed_m_s, slowest_share } = rules.walk;
    this.#most_m_s = speed_m_s * (slowest_share + (1 - slowest_share) * ((seed * 0.37) % 1));
    this.#agent = floor.enter(at, this.#most_m_s);
    if (!this.#agent) throw new Error('there is no room for one more figure');
  }

  // Whether it is on a seat or bed, or on its way there.
  takes(place) {
    return this.goal?.seat === place || this.goal?.bed === place || this.#next?.seat === place || this.#next?.bed === place;
  }

  get is_down() {
    return ['sitting down', 'sitting', 'lying down', 'lying', 'getting up', 'standing up'].includes(this.state);
  }

  // Whether somebody stands in its way.
  get is_stuck() {
    return this.state === 'walking' && this.#stuck_s > rules.stuck_s;
  }

  // Each returns false, and changes nothing, if there is no way.
  go(to) {
    const at = this.#floor.nearest(to, 0.4);
    return at !== null && this.#reaches(at) && this.#begin({ kind: 'floor', spot: at });
  }

  sit(seat) {
    const spot = this.#spot_before(seat);
    return spot !== null && this.#begin({ kind: 'seat', seat, spot, ...this.#on_seat(seat) });
  }

  lie(bed) {
    for (const edge of edges_of(bed)) {
      const spot = this.#spot_before(edge);
      if (spot === null) continue;
      return this.#begin({ kind: 'bed', bed, spot, ...this.#on_bed(bed, edge) });
    }
    return false;
  }

  #on_seat({ at, facing, height }) {
    return { at: below(at), facing: heading_of(facing), height };
  }

  #on_bed({ at, axis, height }, edge) {
    const head = rules.bed.head_share * this.#shape.height;  // the pelvis is a little above the middle of the body
    return { at: below(edge.at), facing: heading_of(edge.facing), height, lying_at: [at[0] + head * axis[0], 0, at[2] + head * axis[2]],
      lying_heading: heading_of(axis.map((value) => -value)) };
  }

  stand() {
    if (this.state === 'lying') {
      this.#set('getting up');
      return true;
    }
    return this.state === 'sitting' && this.#rise();
  }

  // On the floor of a newer plan, with its seats and beds: {seats, beds}. `moved`: a matrix from the frame so far to its own. Returns
  // how far it had to be put aside, metres.
  renew(floor, moved, places) {
    const carry = {
      place: (at) => new Vector3(...at).applyMatrix4(moved).toArray(),
      heading: (angle) => heading_of(new Vector3(Math.sin(angle), 0, Math.cos(angle)).transformDirection(moved).toArray()),
    };
    const velocity = this.#agent?.velocity();
    this.#floor = floor;
    this.#agent = null;
    this.place = carry.place(this.place);
    this.heading = carry.heading(this.heading);
    const goal = this.goal && this.#renewed(this.goal, carry, places);
    this.#next = this.#next && this.#renewed(this.#next, carry, places);
    if (this.is_down) return this.#stay_down(goal ?? this.#left(this.goal, carry), goal === null, velocity);
    return this.#stay_up(goal, velocity);
  }

  // The same goal in a newer plan; null if its seat or bed is gone.
  #renewed(goal, carry, { seats, beds }) {
    const spot = this.#foothold(carry.place(goal.spot));
    if (goal.kind === 'floor') return { kind: 'floor', spot };
    const before = goal.seat ?? goal.bed;
    const now = same_place(goal.kind === 'seat' ? seats : beds, before, carry.place(before.at));
    if (!now) return null;
    if (goal.kind === 'seat') return { kind: 'seat', seat: now, spot, ...this.#on_seat(now) };
    const at = carry.place(goal.at);
    const [edge] = edges_of(now).sort((a, b) => apart(a.at, at) - apart(b.at, at));
    return { kind: 'bed', bed: now, spot, ...this.#on_bed(now, edge) };
  }

  // Where a seat or bed was that is gone.
  #left(goal, carry) {
    const left = { ...goal, spot: this.#foothold(carry.place(goal.spot)), at: below(carry.place(goal.at)), facing: carry.heading(goal.facing) };
    for (const kind of ['seat', 'bed']) {
      if (goal[kind]) left[kind] = { ...goal[kind], at: carry.place(goal[kind].at) };
    }
    if (goal.kind === 'bed') Object.assign(left, { lying_at: below(carry.place(goal.lying_at)), lying_heading: carry.heading(goal.lying_heading) });
    return left;
  }

  #foothold(at) {
    for (const far_m of kFootholds_m) {
      const found = this.#floor.nearest(at, far_m);
      if (found !== null) return found;
    }
    return this.#floor.random() ?? at;
  }

  #stay_down(goal, homeless, velocity) {
    this.goal = goal;
    this.#homeless = homeless;
    if (this.state === 'sitting') this.place = [...goal.at];
    if (this.state === 'lying') this.place = [...goal.lying_at];
    if (velocity) this.#agent = this.#floor.enter(goal.spot, this.#most_m_s);
    return 0;
  }

  #stay_up(goal, velocity) {
    const at = this.#foothold(this.place);
    const aside_m = apart(at, this.place);
    this.place = at;
    this.#agent = this.#floor.enter(at, this.#most_m_s, velocity);
    const goes_on = goal !== null && this.#reaches(goal.spot);
    this.goal = goes_on ? goal : null;
    if (!goes_on) this.state = 'standing';
    else if (this.state === 'walking') this.#agent.go(goal.spot);
    return aside_m;
  }

  leave() {
    this.#agent?.leave();
    this.#agent = null;
  }

  // Only if nobody stands where it will stand; who comes by then goes around.
  #rise() {
    const { spot } = this.goal;
    if (!this.#floor.is_clear(spot)) return false;
    this.#agent = this.#floor.enter(spot, this.#most_m_s);
    if (!this.#agent) return false;
    this.#set('standing up');
    return true;
  }

  // Where it stands when it is up again.
  get #base() {
    return this.is_down ? this.goal.spot : this.place;
  }

  #reaches(at) {
    return this.#floor.way(this.#base, at) !== null;
  }

  #is_clear(at) {
    return this.#agent ? this.#agent.is_clear(at) : this.#floor.is_clear(at);
  }

  #spot_before(seat) {
    for (const { at } of spots_before(seat)) {
      const near = this.#floor.nearest(at, rules.spots.off_m);
      if (near !== null && this.#is_clear(near) && this.#reaches(near)) return near;
    }
    const { ahead_m, off_m, farthest_m } = rules.any_spot;
    const near = this.#floor.nearest([seat.at[0] + ahead_m * seat.facing[0], 0, seat.at[2] + ahead_m * seat.facing[2]], off_m);
    return near !== null && apart(near, seat.at) < farthest_m && this.#is_clear(near) && this.#reaches(near) ? near : null;
  }

  #begin(goal) {
    if (this.is_down) {
      this.#next = goal;
      this.stand();
      return true;
    }
    this.goal = goal;
    this.#agent.go(goal.spot);
    this.#set('walking');
    return true;
  }

  #set(state) {
    this.state = state;
    this.#in_state_s = 0;
    this.#stuck_s = 0;

  }

  // After a step of the crowd.
  update(passed_s) {
    this.#time_s += passed_s;
    this.#in_state_s += passed_s;
    const acts = {
      standing: () => this.#on_feet(passed_s), walking: () => this.#walk(passed_s), turning: () => this.#turn(passed_s),
      'sitting down': () => this.#sit_down(), sitting: () => this.#rest(sitting(this.#shape, this.goal.height)),
      'lying down': () => this.#lie_down(), lying: () => this.#rest(lying(this.#shape, this.goal.height)),
      'getting up': () => this.#get_up(), 'standing up': () => this.#stand_up(),
    };
    acts[this.state]();
  }

  // Follows the crowd, looking where it goes.
  #on_feet(passed_s, facing = null) {
    const before = this.place;
    this.place = this.#agent.place();
    const way = [this.place[0] - before[0], 0, this.place[2] - before[2]];
    const length = Math.hypot(way[0], way[2]);
    const speed = length / passed_s;
    this.#speed += (speed - this.#speed) * Math.min(1, 10 * passed_s);
    const wanted = facing ?? (speed > 0.12 ? heading_of(way) : this.heading);
    const most = (facing === null ? rules.turn_walking_rad_s : rules.turn_rad_s) * passed_s;
    const turn = Math.max(-most, Math.min(most, wrapped(wanted - this.heading) * Math.min(1, 9 * passed_s)));
    this.heading = wrapped(this.heading + turn);
    this.#phase += length / stride_of(this.#shape, this.#speed) + (0.16 * Math.abs(turn));
    const walks = this.#speed > kMoving_m_s;
    this.#gait += ((walks ? 1 : 0) - this.#gait) * Math.min(1, (walks ? 9 : 7) * passed_s);
    const turning = Math.min(1, Math.abs(turn) / passed_s / 1.2);
    const still = mix(standing(this.#shape), shuffling(this.#shape, this.#phase), turning);
    const base = mix(still, walking(this.#shape, this.#phase, this.#speed), this.#gait);
    this.pose = this.#gait < 0.05 ? resting(structured(base), this.#time_s, this.#seed) : base;
    return speed;
  }

  #walk(passed_s) {
    const speed = this.#on_feet(passed_s);
    const left = apart(this.place, this.goal.spot);
    this.#stuck_s = speed < 0.05 ? this.#stuck_s + passed_s : Math.max(0, this.#stuck_s - 2 * passed_s);
    if (left < rules.arrived_m || (left < 0.3 && this.#stuck_s > 1)) return this.#arrive(left);
    if (this.#stuck_s > rules.patience_s) return this.#give_up();
    return null;
  }

  #arrive(left) {
    if (this.goal.kind !== 'floor' && left > 0.2) return this.#give_up();
    this.#agent.stop();
    this.goal.spot = [...this.place];
    if (this.goal.kind !== 'floor') return this.#set('turning');
    this.goal = null;
    return this.#set('standing');
  }

  #give_up() {
    this.#agent.stop();
    this.goal = null;
    this.#set('standing');
  }

  #turn(passed_s) {
    this.#on_feet(passed_s, this.goal.facing);
    const done = Math.abs(wrapped(this.goal.facing - this.heading)) < 0.05;
    if (!done && this.#in_state_s < 4) return;
    if (this.#in_state_s < 0.35) return;
    this.goal.spot = [...this.place];
    this.#set('sitting down');
  }

  // The feet stay where they are, or make a step if the seat is farther; the body goes back over the seat and down.
  #between_seat_and_spot(t, seat_pose) {
    const { spot, at, facing, height } = this.goal;
    const bent = bending(this.#shape, height);
    const up = standing(this.#shape);
    const back = ease(t);
    this.place = between(spot, at, back);
    this.place[1] = spot[1] * (1 - back);
    this.heading = facing;
    const pose = structured(t < 0.5 ? mix(up, bent, ease(2 * t)) : mix(bent, seat_pose, ease(2 * t - 1)));
    const way = [at[0] - spot[0], 0, at[2] - spot[2]];
    const [c, s] = [Math.cos(facing), Math.sin(facing)];
    const ahead = -(way[0] * s + way[2] * c) ;  // the spot, seen from the seat
    const aside = -(way[0] * c - way[2] * s);
    seat_pose.feet.forEach((foot, i) => {
      const start = [up.feet[i][0] + aside * back, up.feet[i][1], up.feet[i][2] + ahead * back];
      const part = ease(Math.min(1, Math.max(0, (t - 0.08 - 0.3 * i) / 0.5)));
      const moved = Math.hypot(foot[0] - start[0], foot[2] - start[2]);
      pose.feet[i] = between([start[0], up.feet[i][1], start[2]], foot, part);
      pose.feet[i][1] += Math.min(0.06, 0.25 * moved) * Math.sin(Math.PI * part);
    });
    this.pose = pose;
  }

  #sit_down() {
    const t = this.#in_state_s / rules.sit_down_s;
    this.#between_seat_and_spot(Math.min(1, t), sitting(this.#shape, this.goal.height));
    if (t < 1) return;
    this.leave();
    this.#set(this.goal.kind === 'bed' ? 'lying down' : 'sitting');
  }

  #swing_onto_bed(t) {
    const { at, facing, lying_at, lying_heading, height } = this.goal;
    const u = ease(t);
    const turn = wrapped(lying_heading - facing);
    this.place = between(at, lying_at, ease(Math.min(1, 1.25 * t)));
    this.heading = facing + turn * ease(Math.min(1, 1.4 * t));
    const seated = sitting(this.#shape, height);
    const flat = lying(this.#shape, height);
    const middle = structured(mix(seated, flat, 0.42));  // the legs come up first, and the arms prop the back
    for (const foot of middle.feet) foot[1] = Math.max(foot[1], height + 0.12);
    middle.tilt = -0.55;
    this.pose = u < 0.5 ? mix(seated, middle, 2 * u) : mix(middle, flat, 2 * u - 1);
  }

  #lie_down() {
    const t = this.#in_state_s / rules.lie_down_s;
    this.#swing_onto_bed(Math.min(1, t));
    if (t >= 1) this.#set('lying');
  }

  #rest(pose) {
    this.pose = resting(structured(pose), this.#time_s, this.#seed);
    if (this.#next !== null || this.#homeless) this.stand();
  }

  #get_up() {
    const t = this.#in_state_s / rules.lie_down_s;
    this.#swing_onto_bed(Math.max(0, 1 - t));
    if (t >= 1) this.#rise();  // or waits on the edge
  }

  #stand_up() {
    const t = this.#in_state_s / rules.sit_down_s;
    this.#between_seat_and_spot(Math.max(0, 1 - t), sitting(this.#shape, this.goal.height));
    if (t < 1) return;
    this.place = this.#agent.place();
    this.#gait = this.#speed = 0;
    const next = this.#next;
    this.goal = this.#next = null;
    this.#homeless = false;
    this.#set('standing');
    if (next !== null) this.#begin(next);
  }

  // For the body.
  get position() {
    return new Vector3(...this.place);
  }
}

function structured(pose) {
  return { ...pose, pelvis: [...pose.pelvis], feet: pose.feet.map((foot) => [...foot]), toes: [...pose.toes], arms: pose.arms.map((arm) => ({ ...arm })) };
}
