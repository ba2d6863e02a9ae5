// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Things that stand on tables: what they look like, and simple hulls of them for the physics. Their origin is where they touch the table.
import { CatmullRomCurve3, DoubleSide, Group, LatheGeometry, Mesh, MeshPhongMaterial, SphereGeometry, TubeGeometry, Vector2, Vector3 } from 'three';

const lathe = (points, round = 28) => new LatheGeometry(points.map(([x, y]) => new Vector2(x, y)), round);
const tube = (points, radius, steps = 18) => new TubeGeometry(new CatmullRomCurve3(points.map((p) => new Vector3(...p))), steps, radius, 8);
const glazed = (color) => new MeshPhongMaterial({ color, shininess: 70, specular: '#555555', side: DoubleSide });
const dull = (color) => new MeshPhongMaterial({ color, shininess: 6, specular: '#111111', side: DoubleSide });

function cup() {
  const glaze = glazed('#f4f1ea');
  const band = glazed('#2c7da0');
  const group = new Group();
  group.add(new Mesh(lathe([[0, 0.003], [0.026, 0.002], [0.029, 0], [0.031, 0.004], [0.036, 0.03], [0.04, 0.07], [0.042, 0.088], [0.0405, 0.089], [0.038, 0.07], [0.033, 0.02], [0, 0.014]]), glaze));
  group.add(new Mesh(lathe([[0.0387, 0.052], [0.0402, 0.064], [0.0412, 0.074]]), band));
  group.add(new Mesh(lathe([[0, 0.074], [0.0385, 0.0742]]), dull('#5a3620')));
  group.add(new Mesh(tube([[0.036, 0.072, 0], [0.062, 0.072, 0], [0.066, 0.046, 0], [0.054, 0.024, 0], [0.033, 0.024, 0]], 0.0052), glaze));
  return group;
}

function teapot() {
  const glaze = glazed('#b5473a');
  const group = new Group();
  group.add(new Mesh(lathe([[0, 0.004], [0.042, 0.002], [0.046, 0], [0.05, 0.008], [0.072, 0.036], [0.078, 0.062], [0.07, 0.092], [0.048, 0.112], [0.04, 0.116], [0.04, 0.113], [0, 0.112]]), glaze));
  group.add(new Mesh(lathe([[0.042, 0.115], [0.038, 0.123], [0.02, 0.131], [0.008, 0.134], [0.0075, 0.139], [0.012, 0.145], [0.01, 0.152], [0, 0.154]]), glaze));
  group.add(new Mesh(tube([[-0.066, 0.045, 0], [-0.094, 0.056, 0], [-0.107, 0.084, 0], [-0.125, 0.107, 0]], 0.0115), glaze));
  group.add(new Mesh(tube([[0.052, 0.1, 0], [0.088, 0.112, 0], [0.112, 0.088, 0], [0.1, 0.05, 0], [0.072, 0.038, 0]], 0.0072, 24), glaze));
  return group;
}

function plant() {
  const group = new Group();
  group.add(new Mesh(lathe([[0, 0.002], [0.042, 0], [0.046, 0.004], [0.06, 0.085], [0.066, 0.088], [0.066, 0.106], [0.059, 0.106], [0.055, 0.09], [0, 0.09]]), dull('#b86a45')));
  group.add(new Mesh(lathe([[0, 0.098], [0.057, 0.094]]), dull('#3b2a1e')));
  const greens = [dull('#3f7d3c'), dull('#56984a'), dull('#2f6a3a')];
  for (let i = 0; i < 15; ++i) {
    const turn = i * 2.39996;  // the golden angle: no leaf lies above another one
    const [rise, reach] = [0.3 - 0.011 * i, 0.035 + 0.0075 * i];
    const stem = [[0, 0.095, 0], [0.25 * reach, 0.095 + 0.5 * rise, 0], [0.8 * reach, 0.095 + rise * 0.82, 0]];
    const branch = new Group();
    branch.add(new Mesh(tube(stem, 0.0022, 8), greens[2]));
    const leaf = new Mesh(new SphereGeometry(0.036, 10, 7).scale(1.25, 0.11, 0.56), greens[i % 3]);
    leaf.position.set(0.8 * reach + 0.026, 0.095 + rise * 0.82 + 0.004, 0);
    leaf.rotation.z = 0.5 - 0.06 * i;
    branch.add(leaf);
    branch.rotation.y = turn;
    group.add(branch);
  }
  return group;
}

// hull: upright cylinders [radius, half height, height of the middle]; the heavier part comes first.
export const kThings = {
  cup: { make: cup, hull: [[0.038, 0.0445, 0.0445]], mass_kg: 0.3 },
  teapot: { make: teapot, hull: [[0.066, 0.056, 0.056], [0.03, 0.02, 0.132]], mass_kg: 0.9 },
  plant: { make: plant, hull: [[0.055, 0.053, 0.053], [0.075, 0.09, 0.25]], mass_kg: 1.4 },
};
