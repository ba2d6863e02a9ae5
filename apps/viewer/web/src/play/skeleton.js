// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// From a pose to places of joints: the back and the arms by their angles, the legs by where the feet are.
import { Euler, Quaternion, Vector3 } from 'three';

const kX = new Vector3(1, 0, 0);
const kY = new Vector3(0, 1, 0);
const kZ = new Vector3(0, 0, 1);
const around = (axis, angle) => new Quaternion().setFromAxisAngle(axis, angle);

// The knee between hip and ankle: on the side to which `toward` points. The ankle comes nearer if the leg is too short.
export function knee_of(hip, ankle, { thigh, shin }, toward) {
  const leg = ankle.clone().sub(hip);
  const reach = (thigh + shin) * 0.999;
  const length = Math.min(reach, Math.max(Math.abs(thigh - shin) + 1e-3, leg.length()));
  const along = leg.normalize();
  const foot = hip.clone().addScaledVector(along, length);
  const share = (thigh * thigh - shin * shin + length * length) / (2 * length);
  const out = Math.sqrt(Math.max(0, thigh * thigh - share * share));
  const side = toward.clone().addScaledVector(along, -toward.dot(along));
  if (side.lengthSq() < 1e-6) side.copy(kY).addScaledVector(along, -along.y);
  return { knee: hip.clone().addScaledVector(along, share).addScaledVector(side.normalize(), out), ankle: foot };
}

// The joints in the frame of the floor: place and heading say where the figure's own frame is.
export function joints_of(pose, shape, place, heading) {
  const facing = around(kY, heading);
  const to_floor = ([x, y, z]) => new Vector3(x, y, z).applyQuaternion(facing).add(place);
  const pelvis = to_floor(pose.pelvis);
  const hips = facing.clone().multiply(new Quaternion().setFromEuler(new Euler(pose.tilt, pose.turn, pose.roll, 'YXZ')));
  const chest = hips.clone().multiply(new Quaternion().setFromEuler(new Euler(pose.lean, pose.twist, -pose.roll, 'YXZ')));
  const from = (base, turn, x, y, z) => new Vector3(x, y, z).applyQuaternion(turn).add(base);
  const waist = from(pelvis, hips, 0, shape.waist, 0);
  const neck = from(waist, chest, 0, shape.chest, 0);
  const skull = chest.clone().multiply(new Quaternion().setFromEuler(new Euler(-0.6 * pose.lean + pose.nod, pose.look - 0.5 * pose.twist, 0, 'YXZ')));
  const head = from(neck, skull, 0, shape.neck + shape.head, 0.012);
  const joints = { pelvis, hips, waist, chest, neck, head, skull, legs: [], arms: [] };
  [1, -1].forEach((s, i) => {
    const hip = from(pelvis, hips, s * shape.hip_half, -0.01, 0);
    const ahead = new Vector3(s * 0.10, 0.12, 1).applyQuaternion(hips);
    const { knee, ankle } = knee_of(hip, to_floor(pose.feet[i]), shape, ahead);
    const foot = facing.clone().multiply(around(kY, s * 0.12)).multiply(around(kX, pose.toes[i]));
    joints.legs.push({ hip, knee, ankle, foot });
    joints.arms.push(arm_of(pose.arms[i], s, shape, from(waist, chest, s * shape.shoulder_half * 0.97, shape.chest - 0.048, 0), chest));
  });
  return joints;
}

function arm_of({ swing, out, elbow }, s, shape, shoulder, chest) {
  const upper = chest.clone().multiply(around(kX, -swing)).multiply(around(kZ, s * out));
  const lower = upper.clone().multiply(around(kX, -elbow)).multiply(around(kZ, -s * out * 1.2));
  const down = (base, turn, length) => new Vector3(0, -length, 0).applyQuaternion(turn).add(base);
  const bend = down(shoulder, upper, shape.upper_arm);
  const wrist = down(bend, lower, shape.forearm);
  return { shoulder, elbow: bend, wrist, hand: down(wrist, lower, shape.hand), turn: lower };
}
