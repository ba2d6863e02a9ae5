// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The looks of an insect robot: a shell of two halves, a head with two lamps, six legs that step three at a time.
import { CircleGeometry, CylinderGeometry, Group, Mesh, MeshBasicMaterial, MeshPhongMaterial, SphereGeometry, Vector3 } from 'three';
import { soft_edge } from './body.js';

const kStride_m = 0.030;
const kUp = new Vector3(0, 1, 0);
const kShells = ['#1d9a8a', '#d2582f', '#4a67c8', '#c99a1f'];
const kBack = [0.028, 0.002, -0.026];  // where legs begin along the body

export class InsectBody {
  group = new Group();
  #legs = [];

  constructor(number) {
    const shell = new MeshPhongMaterial({ color: kShells[number % kShells.length], shininess: 90, specular: '#a8b4b8' });
    const dark = new MeshPhongMaterial({ color: '#2a2f36', shininess: 50 });
    const lamp = new MeshBasicMaterial({ color: '#ffe9a0' });
    const add = (geometry, material, x, y, z) => {
      const mesh = new Mesh(geometry, material);
      mesh.position.set(x, y, z);
      this.group.add(mesh);
      return mesh;
    };
    for (const s of [1, -1]) add(new SphereGeometry(0.03, 18, 12, 0, 2 * Math.PI, 0, Math.PI / 2).scale(0.62, 0.72, 1.35), shell, s * 0.0085, 0.014, -0.008).rotation.z = -s * 0.16;
    add(new SphereGeometry(0.029, 16, 10).scale(0.85, 0.3, 1.3), dark, 0, 0.014, -0.006);
    add(new SphereGeometry(0.017, 14, 10).scale(1.15, 0.75, 0.85), dark, 0, 0.017, 0.036);
    for (const s of [1, -1]) {
      add(new SphereGeometry(0.0045, 8, 6), lamp, s * 0.0105, 0.021, 0.048);
      const feeler = add(new CylinderGeometry(0.0008, 0.0012, 0.034, 5), dark, s * 0.014, 0.031, 0.058);
      feeler.rotation.set(0.9, 0, -s * 0.5);
    }
    for (let i = 0; i < 6; ++i) this.#legs.push([add(new CylinderGeometry(0.0024, 0.003, 1, 6), dark, 0, 0, 0), add(new CylinderGeometry(0.0012, 0.0024, 1, 6), dark, 0, 0, 0)]);
    const shade = new MeshBasicMaterial({ color: '#000000', transparent: true, opacity: 0.34, depthWrite: false, polygonOffset: true, polygonOffsetFactor: -6, polygonOffsetUnits: -6 });
    shade.onBeforeCompile = soft_edge;
    const shadow = add(new CircleGeometry(1, 20).rotateX(-Math.PI / 2).scale(0.046, 1, 0.062), shade, 0, 0.004, 0);
    shadow.geometry.computeBoundingSphere();
  }

  // lift_m: from its navigation mesh to the surface.
  hold(insect, lift_m) {
    const [x, y, z] = insect.place;
    this.group.position.set(x, y + lift_m, z);
    this.group.rotation.y = insect.heading;
    const phase = insect.travelled_m / kStride_m;
    this.#legs.forEach(([upper, lower], i) => {
      const s = i % 2 === 0 ? 1 : -1;
      const row = Math.floor(i / 2);
      const q = (phase + ((row + (s > 0 ? 0 : 1)) % 2) * 0.5) % 1;
      const half = kStride_m / 4;
      const along = q < 0.5 ? half * (1 - 4 * q) : half * (4 * q - 3);
      const lift = q < 0.5 ? 0 : 0.008 * Math.sin(2 * Math.PI * (q - 0.5));
      const foot = new Vector3(s * (0.043 - 0.004 * Math.abs(row - 1)), 0.001 + lift, kBack[row] * 1.65 + along);
      const hip = new Vector3(s * 0.017, 0.013, kBack[row]);
      const bend = hip.clone().lerp(foot, 0.52).add(new Vector3(s * 0.004, 0.017, 0));
      stretch(upper, hip, bend);
      stretch(lower, foot, bend);
    });
  }

  dispose() {
    this.group.traverse((part) => { part.geometry?.dispose(); part.material?.dispose(); });
  }
}

function stretch(mesh, from, to) {
  const along = to.clone().sub(from);
  mesh.position.copy(from).addScaledVector(along, 0.5);
  mesh.scale.y = along.length();
  mesh.quaternion.setFromUnitVectors(kUp, along.normalize());
}
