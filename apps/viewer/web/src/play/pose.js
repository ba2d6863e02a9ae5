// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// How a figure holds itself. A pose is plain numbers, so that two poses mix: where pelvis, ankles are in the figure's frame
// (origin on the floor below it, y up, z ahead, x to its left), angles of back, head and arms in radians.
const kStance = 0.62;  // of a cycle of two steps each foot is on the floor
const kTau = 2 * Math.PI;

const side = [1, -1];  // left, right

export function standing(shape) {
  return {
    pelvis: [0, shape.hip, 0], tilt: 0, roll: 0, turn: 0, lean: 0.02, twist: 0, nod: 0, look: 0,
    feet: side.map((s) => [s * shape.hip_half * 1.05, shape.ankle, 0]), toes: [0, 0],
    arms: side.map(() => ({ swing: 0.04, out: 0.12, elbow: 0.18 })),
  };
}

// One stride takes this long a way, in metres: who walks slowly takes small steps.
export function stride_of(shape, speed_m_s) {
  return shape.height * (0.30 + 0.42 * Math.min(1.4, speed_m_s));
}

function step(phase, half_m, shape) {
  const q = phase - Math.floor(phase);
  if (q < kStance) {
    const u = q / kStance;
    const heel = Math.max(0, u - 0.72) / 0.28;  // the heel leaves the floor before the toes do
    const strike = Math.max(0, 0.18 - u) / 0.18;
    return { z: half_m * (1 - 2 * u) + 0.25 * heel * heel * shape.ankle, y: shape.ankle * (1 + 0.75 * heel * heel + 0.1 * strike), toe: 0.5 * heel * heel - 0.3 * strike };
  }
  const u = (q - kStance) / (1 - kStance);
  const ease = u * u * (3 - 2 * u);
  const lift = Math.sin(Math.PI * u);
  return { z: half_m * (2 * ease - 1) + 0.25 * shape.ankle * (1 - u), y: shape.ankle * (1 + 0.75 * (1 - u) ** 2 + 0.1 * u) + 0.055 * shape.height * lift * (1 - 0.4 * u),
    toe: 0.5 * (1 - u) ** 2 + 0.35 * lift * (1 - u) - 0.3 * u * u };
}

// Walking: `phase` counts strides; while a foot is on the floor it goes back as fast as the body goes ahead.
export function walking(shape, phase, speed_m_s) {
  const pose = standing(shape);
  const half = (stride_of(shape, speed_m_s) * kStance) / 2;
  const wave = Math.sin(kTau * phase);
  const brisk = Math.min(1, speed_m_s / 1.1);
  side.forEach((s, i) => {
    const foot = step(phase + i * 0.5, half, shape);
    pose.feet[i] = [s * shape.hip_half * 0.9, foot.y, foot.z];
    pose.toes[i] = foot.toe;
    const swing = Math.cos(kTau * (phase + 0.06 + i * 0.5));
    pose.arms[i] = { swing: -0.42 * brisk * swing + 0.04, out: 0.11, elbow: 0.32 + 0.22 * brisk * Math.max(0, -swing) };
  });
  const settled = kTau * (2 * phase - 2 * kStance / 2);
  pose.pelvis = [0.016 * wave, shape.hip - 0.022 * shape.height + 0.009 * shape.height * Math.cos(settled), 0];
  pose.roll = -0.035 * brisk * wave;
  pose.turn = 0.11 * brisk * Math.cos(kTau * phase) * -1;
  pose.twist = 0.2 * brisk * Math.cos(kTau * phase);
  pose.lean = 0.035 + 0.035 * brisk;
  return pose;
}

// Turning on the spot: feet rise in turn. `phase` as above.
export function shuffling(shape, phase) {
  const pose = standing(shape);
  side.forEach((s, i) => { pose.feet[i][1] += 0.035 * Math.max(0, Math.sin(kTau * (phase + i * 0.5))); });
  pose.pelvis = [0.012 * Math.sin(kTau * phase), shape.hip - 0.008, 0];
  return pose;
}

// Breath and small shifts of weight while nothing happens.
export function resting(pose, time_s, seed) {
  const slow = Math.sin(0.55 * time_s + seed);
  const breath = Math.sin(1.5 * time_s + 2 * seed);
  pose.lean += 0.008 * breath;
  pose.look += 0.30 * Math.sin(0.23 * time_s + 3 * seed) * Math.max(0, slow);
  pose.nod += 0.03 * Math.sin(0.31 * time_s + seed);
  for (const arm of pose.arms) arm.out += 0.012 * breath;
  return pose;
}

// Sitting with the figure's origin below the middle of the seat, `seat_m` above the floor.
export function sitting(shape, seat_m) {
  const pelvis = seat_m + shape.buttocks;
  const reach = shape.thigh * 0.98;
  const pose = standing(shape);
  pose.pelvis = [0, pelvis, 0];
  pose.lean = 0.02;
  pose.tilt = -0.08;
  const hip_to_ankle = pelvis - shape.ankle;
  const low = hip_to_ankle < shape.shin;  // low seats: the feet come nearer, the knees rise
  const ahead = low ? reach * 0.92 : Math.min(reach, Math.sqrt(Math.max(0.02, (shape.thigh + shape.shin) ** 2 * 0.93 - hip_to_ankle ** 2)));
  pose.feet = side.map((s) => [s * shape.hip_half * 1.35, Math.max(shape.ankle, pelvis - shape.shin - 0.02 - Math.max(0, 0)), ahead + 0.03]);
  if (hip_to_ankle < shape.thigh + shape.shin) for (const foot of pose.feet) foot[1] = shape.ankle;
  pose.arms = side.map(() => ({ swing: 0.42, out: 0.16, elbow: 0.98 }));
  pose.nod = 0.04;
  return pose;
}

// Leaning ahead on the way down and up: the weight has to be over the feet.
export function bending(shape, seat_m) {
  const pose = sitting(shape, seat_m);
  pose.pelvis[1] = seat_m + shape.buttocks + 0.5 * Math.max(0, shape.hip - seat_m - shape.buttocks);
  pose.lean = 0.55;
  pose.nod = -0.25;
  pose.arms = side.map(() => ({ swing: 0.65, out: 0.14, elbow: 0.5 }));
  return pose;
}

// Lying on the back: the whole figure is tilted back by a right angle; the feet are where they would be, seen from the pelvis.
export function lying(shape, bed_m) {
  const pose = standing(shape);
  const legs = (shape.thigh + shape.shin) * 0.985;
  pose.pelvis = [0, bed_m + shape.back, 0];
  pose.tilt = -Math.PI / 2;
  pose.lean = 0.04;
  pose.nod = 0.16;
  pose.feet = side.map((s) => [s * shape.hip_half * 1.5, bed_m + shape.back - 0.012, legs]);
  pose.toes = [-1.35, -1.35];
  pose.arms = side.map((s, i) => ({ swing: i === 0 ? 0.06 : 0.5, out: i === 0 ? 0.3 : 0.2, elbow: i === 0 ? 0.15 : 1.5 }));
  return pose;
}

const lerp = (a, b, t) => a + (b - a) * t;

function mixed(a, b, t) {
  if (typeof a === 'number') return lerp(a, b, t);
  if (Array.isArray(a)) return a.map((value, i) => mixed(value, b[i], t));
  return Object.fromEntries(Object.keys(a).map((key) => [key, mixed(a[key], b[key], t)]));
}

export function mix(a, b, t) {
  if (t <= 0) return a;
  if (t >= 1) return b;
  return mixed(a, b, t);
}

export const ease = (t) => { const u = Math.min(1, Math.max(0, t)); return u * u * (3 - 2 * u); };
