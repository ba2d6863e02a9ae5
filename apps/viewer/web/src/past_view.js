// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// An earlier time drawn into the map: boxes of what was there, arrows to where it is now, ways of who moved.
import { BoxGeometry, DoubleSide, Group, InstancedMesh, Matrix4, MeshBasicMaterial, Vector3 } from 'three';
import { count_until, side_of } from './past.js';
import { box_points, kLineLayer, replace, segments } from './trail.js';

const kArcSteps = 20;
const kHead_m = 0.22;

// An arc from one place to the other, higher in its middle, with a head, as pairs of places.
export function arrow_points(from, to, up) {
  const [a, b, upward] = [from, to, up].map((triple) => new Vector3(...triple));
  const length = a.distanceTo(b);
  if (length < 1e-6) return [];
  const middle = a.clone().lerp(b, 0.5).addScaledVector(upward, 0.25 + 0.3 * length);
  const on_arc = (share) => a.clone().lerp(middle, share).lerp(middle.clone().lerp(b, share), share);
  const points = Array.from({ length: kArcSteps }, (_, i) => [...on_arc(i / kArcSteps).toArray(), ...on_arc((i + 1) / kArcSteps).toArray()]).flat();
  const along = b.clone().sub(middle).normalize();
  const aside = along.clone().cross(upward);
  if (aside.lengthSq() < 1e-6) aside.set(1, 0, 0).cross(along);
  aside.normalize();
  const head = Math.min(kHead_m, 0.35 * length);
  for (const sign of [-1, 1]) points.push(...b.toArray(), ...b.clone().addScaledVector(along, -head).addScaledVector(aside, 0.5 * sign * head).toArray());
  return points;
}

// Lines that surface hides are faint, not gone.
class SeenThrough {
  front;
  #behind;

  constructor(width_px, opacity) {
    this.front = segments('#ffffff', width_px);
    this.#behind = segments('#ffffff', width_px);
    Object.assign(this.#behind.material, { depthTest: false, opacity });
    this.#behind.renderOrder = this.front.renderOrder = 1;
  }

  get parts() {
    return [this.front, this.#behind];
  }

  set color(color) {
    for (const { material } of this.parts) material.color.set(color);
  }

  put(points) {
    for (const lines of this.parts) replace(lines, points);
  }

  // Only the first segments.
  show(count) {
    for (const lines of this.parts) {
      lines.geometry.instanceCount = count;
      lines.visible = count > 0;
    }
  }
}

export class PastView {
  group = new Group();
  #past;
  #up;
  #times = [];
  #ways = new SeenThrough(3, 0.28);
  #movers = new SeenThrough(2.5, 0.3);
  #ghosts = new SeenThrough(2, 0.3);
  #arrows = new SeenThrough(2.5, 0.4);
  #fill;
  #drawn = '';  // which ghosts and arrows

  constructor(past, up) {
    this.#past = past;
    this.#up = up;
    const most = Math.max(1, past.objects.filter(({ gone_s }) => gone_s !== null).length);
    this.#fill = new InstancedMesh(new BoxGeometry(1, 1, 1), new MeshBasicMaterial({ transparent: true, opacity: 0.2, depthWrite: false, side: DoubleSide, toneMapped: false }), most);
    this.#fill.frustumCulled = false;
    this.#fill.layers.set(kLineLayer);
    this.#fill.count = 0;
    this.group.add(this.#fill, ...[this.#ways, this.#movers, this.#ghosts, this.#arrows].flatMap(({ parts }) => parts));
  }

  set_colors({ ghost, moving }) {
    this.#fill.material.color.set(ghost);
    for (const lines of [this.#ghosts, this.#arrows]) lines.color = ghost;
    for (const lines of [this.#ways, this.#movers]) lines.color = moving;
  }

  // Another choice of classes, whose ways are put together anew.
  choose(is_shown) {
    const { places, times } = this.#past.segments(this.#up, is_shown);
    this.#times = times;
    this.#ways.put(places);
  }

  // ghosts: objects, moves: [{from, to}], moving: [{box}], as Past gives them.
  show(time_s, { ghosts, moves, moving }) {
    this.#ways.show(count_until(this.#times, time_s));
    this.#movers.put(moving.flatMap(({ box }) => box_points(box.min_m, box.max_m)));
    const signature = JSON.stringify([ghosts.map(({ id }) => id), moves.map(({ from }) => from.id)]);
    if (signature === this.#drawn) return;
    this.#drawn = signature;
    this.#ghosts.put(ghosts.flatMap(({ min_m, max_m }) => box_points(min_m, max_m)));
    this.#arrows.put(moves.flatMap(({ from, to }) => arrow_points(side_of(from, this.#up, 1), side_of(to, this.#up, 1), this.#up)));
    this.#fill_boxes(ghosts);
  }

  close() {
    this.group.removeFromParent();
    for (const lines of [this.#ways, this.#movers, this.#ghosts, this.#arrows]) lines.put([]);
    this.#fill.geometry.dispose();
    this.#fill.material.dispose();
    this.#fill.dispose();
  }

  #fill_boxes(ghosts) {
    const placed = new Matrix4();
    ghosts.forEach(({ min_m, max_m }, i) => {
      const center = [0, 1, 2].map((k) => (min_m[k] + max_m[k]) / 2);
      placed.makeScale(...[0, 1, 2].map((k) => Math.max(1e-3, max_m[k] - min_m[k]))).setPosition(...center);
      this.#fill.setMatrixAt(i, placed);
    });
    this.#fill.count = ghosts.length;
    this.#fill.instanceMatrix.needsUpdate = true;
  }
}
