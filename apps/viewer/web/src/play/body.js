// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The looks of a figure: rounded parts between its joints. Everything is made here from a few numbers.
import { BufferGeometry, CircleGeometry, Float32BufferAttribute, Group, LatheGeometry, Mesh, MeshBasicMaterial, MeshLambertMaterial, Quaternion, SphereGeometry, Vector2, Vector3 } from 'three';
import { joints_of } from './skeleton.js';

const kRound = 14;
const kUp = new Vector3(0, 1, 0);

// A rod of unit length along y with round ends; radii in metres at its lower and upper end.
function rod(low_m, high_m, length_m, bulge = 0) {
  const points = [];
  for (let i = 0; i <= 5; ++i) points.push(new Vector2(low_m * Math.sin((i / 5) * Math.PI / 2), -low_m * Math.cos((i / 5) * Math.PI / 2)));
  for (let i = 1; i < 6; ++i) {
    const t = i / 6;
    points.push(new Vector2(low_m + (high_m - low_m) * t + bulge * Math.sin(Math.PI * t), length_m * t));
  }
  for (let i = 0; i <= 5; ++i) points.push(new Vector2(high_m * Math.cos((i / 5) * Math.PI / 2), length_m + high_m * Math.sin((i / 5) * Math.PI / 2)));
  points[0].x = points.at(-1).x = 0;
  return new LatheGeometry(points, kRound);
}

// A smooth body through rings: [height, half width, half depth, forward].
export function barrel(rings, round = 18) {
  const places = [];
  const corners = [];
  const shape = (t) => Math.sign(t) * Math.abs(t) ** 0.86;  // between a circle and a rectangle
  rings.forEach(([y, wide, deep, ahead = 0]) => {
    for (let i = 0; i < round; ++i) {
      const turn = (2 * Math.PI * i) / round;
      places.push(wide * shape(Math.sin(turn)), y, ahead + deep * shape(Math.cos(turn)));
    }
  });
  for (let r = 0; r + 1 < rings.length; ++r) {
    for (let i = 0; i < round; ++i) {
      const [a, b] = [r * round + i, r * round + ((i + 1) % round)];
      corners.push(a, b, a + round, b, b + round, a + round);
    }
  }
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new Float32BufferAttribute(places, 3));
  geometry.setIndex(corners);
  geometry.computeVertexNormals();
  return geometry;
}

function torso(shape) {
  const { shoulder_half: half, chest } = shape;
  const top = chest + 0.018;
  return barrel([[-0.055, 0, 0], [-0.05, half * 0.62, half * 0.42], [-0.02, half * 0.76, half * 0.53], [0.04, half * 0.72, half * 0.5, 0.004], [chest * 0.3, half * 0.76, half * 0.52, 0.006],
    [chest * 0.6, half * 0.95, half * 0.6, 0.008], [chest * 0.8, half * 1.04, half * 0.58, 0.004], [chest * 0.93, half * 0.98, half * 0.48, -0.002], [top - 0.004, half * 0.66, half * 0.36, -0.006],
    [top + 0.018, half * 0.36, half * 0.3, -0.004], [top + 0.024, 0, 0]]);
}

function pelvis(shape) {
  const half = shape.shoulder_half;
  return barrel([[-0.085, 0, 0], [-0.08, half * 0.5, half * 0.42, -0.004], [-0.05, half * 0.82, half * 0.62, -0.008], [0, half * 0.86, half * 0.62, -0.01], [0.05, half * 0.78, half * 0.55, -0.004],
    [0.085, half * 0.68, half * 0.48], [0.09, 0, 0]]);
}

function shoe(shape) {
  const [l, w, h] = [shape.foot, shape.foot_half, shape.ankle];
  const rings = [[-0.28, 0, 0], [-0.275, 0.62, 0.55], [-0.2, 0.95, 0.95], [0, 0.98, 1], [0.25, 1.05, 0.8], [0.5, 1.15, 0.62], [0.66, 0.9, 0.5], [0.72, 0.4, 0.3], [0.725, 0, 0]];
  const geometry = barrel(rings.map(([at, wide, high]) => [at * l, wide * w, high * h * 0.62, -(h - high * h * 0.62)]), 14);
  geometry.rotateX(Math.PI / 2);  // its length along z, its sole down
  geometry.scale(1, -1, 1);
  const index = geometry.getIndex();
  for (let i = 0; i < index.count; i += 3) { const kept = index.getX(i); index.setX(i, index.getX(i + 1)); index.setX(i + 1, kept); }
  geometry.scale(1, 1, 1);
  geometry.computeVertexNormals();
  geometry.computeBoundingBox();
  return geometry.translate(0, -h - geometry.boundingBox.min.y, 0);
}

function hair(radius) {
  const geometry = new SphereGeometry(radius * 1.09, 18, 12, 0, 2 * Math.PI, 0, Math.PI * 0.56);
  geometry.rotateX(-0.48);
  return geometry.scale(0.97, 1.03, 1.04).translate(0, 0.006, -0.006);
}

export class Body {
  group = new Group();
  #shape;
  #parts = {};

  constructor(shape, outfit) {
    this.#shape = shape;
    const paint = Object.fromEntries(Object.entries(outfit).map(([name, color]) => [name, new MeshLambertMaterial({ color })]));
    const part = (name, geometry, material) => {
      const mesh = new Mesh(geometry, material);
      mesh.matrixAutoUpdate = true;
      this.#parts[name] = mesh;
      this.group.add(mesh);
      return mesh;
    };
    const r = shape.height;
    part('pelvis', pelvis(shape), paint.trousers);
    part('torso', torso(shape), paint.shirt);
    part('neck', rod(0.030 * r, 0.026 * r, shape.neck + 0.02), paint.skin);
    this.#add_head(part, paint, shape.head);
    for (const i of [0, 1]) {
      part(`thigh${i}`, rod(0.034 * r, 0.049 * r, shape.thigh, 0.003 * r), paint.trousers);  // from the knee up
      part(`shin${i}`, rod(0.025 * r, 0.034 * r, shape.shin, 0.004 * r), paint.trousers);
      part(`foot${i}`, shoe(shape), paint.shoes);
      part(`upper${i}`, rod(0.0225 * r, 0.0285 * r, shape.upper_arm), paint.shirt);
      part(`lower${i}`, rod(0.0175 * r, 0.0215 * r, shape.forearm), paint.skin);
      part(`hand${i}`, new SphereGeometry(0.026 * r, 12, 9).scale(0.72, 1.25, 1), paint.skin);
    }
    const shade = new MeshBasicMaterial({ color: '#000000', transparent: true, opacity: 0.26, depthWrite: false, polygonOffset: true, polygonOffsetFactor: -6, polygonOffsetUnits: -6 });
    shade.onBeforeCompile = soft_edge;
    this.shadow = new Mesh(new CircleGeometry(1, 28).rotateX(-Math.PI / 2), shade);
    this.shadow.renderOrder = 1;
    this.shadow.raycast = () => {};  // nobody clicks a shadow
    this.group.add(this.shadow);
  }

  #add_head(part, paint, radius) {
    const head = part('head', new SphereGeometry(radius, 20, 16).scale(0.9, 1.08, 0.98), paint.skin);
    head.add(new Mesh(hair(radius), paint.hair));
    const dark = new MeshLambertMaterial({ color: '#22201e' });
    for (const s of [1, -1]) {
      const eye = new Mesh(new SphereGeometry(radius * 0.1, 8, 6).scale(1, 1.35, 0.6), dark);
      eye.position.set(s * radius * 0.34, radius * 0.1, radius * 0.91);
      const ear = new Mesh(new SphereGeometry(radius * 0.2, 8, 6).scale(0.5, 1.1, 0.8), paint.skin);
      ear.position.set(s * radius * 0.9, -radius * 0.02, -radius * 0.05);
      head.add(eye, ear);
    }
    const nose = new Mesh(new SphereGeometry(radius * 0.13, 8, 6).scale(0.85, 1.1, 1), paint.skin);
    nose.position.set(0, -radius * 0.12, radius * 0.98);
    head.add(nose);
  }

  // floor_m: the height of what its shadow falls on.
  hold(pose, place, heading, floor_m) {
    const joints = joints_of(pose, this.#shape, place, heading);
    const parts = this.#parts;
    const put = (mesh, at, turn) => { mesh.position.copy(at); mesh.quaternion.copy(turn); };
    put(parts.pelvis, joints.pelvis, joints.hips);
    put(parts.torso, joints.waist, joints.chest);
    put(parts.head, joints.head, joints.skull);
    between(parts.neck, joints.neck, joints.head);
    joints.legs.forEach(({ hip, knee, ankle, foot }, i) => {
      between(parts[`thigh${i}`], knee, hip);
      between(parts[`shin${i}`], ankle, knee);
      put(parts[`foot${i}`], ankle, foot);
    });
    joints.arms.forEach(({ shoulder, elbow, wrist, hand, turn }, i) => {
      between(parts[`upper${i}`], elbow, shoulder);
      between(parts[`lower${i}`], wrist, elbow);
      put(parts[`hand${i}`], hand, turn);
    });
    const flat = Math.max(0, -pose.tilt) / (Math.PI / 2);
    this.shadow.position.set(joints.waist.x, floor_m + 0.012, joints.waist.z);
    this.shadow.rotation.y = heading;
    this.shadow.scale.set(0.26, 1, 0.26 + 0.5 * flat);
    return joints;
  }

  dispose() {
    this.group.traverse((part) => { part.geometry?.dispose(); part.material?.dispose(); });
  }
}

const kTurn = new Quaternion();
const kAlong = new Vector3();

function between(mesh, from, to) {
  mesh.position.copy(from);
  mesh.quaternion.copy(kTurn.setFromUnitVectors(kUp, kAlong.copy(to).sub(from).normalize()));
}

// Fades a circle out towards its rim.
export function soft_edge(shader) {
  shader.vertexShader = shader.vertexShader.replace('#include <common>', '#include <common>\nvarying float vRim;').replace('#include <begin_vertex>', '#include <begin_vertex>\nvRim = length(position.xz);');
  shader.fragmentShader = shader.fragmentShader.replace('#include <common>', '#include <common>\nvarying float vRim;')
    .replace('#include <opaque_fragment>', 'diffuseColor.a *= pow(max(0.0, 1.0 - vRim * vRim), 1.4);\n#include <opaque_fragment>');
}
