// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Lines in the map: where the camera went, what it sees now, and the box of the selected object.
import { Box3, Group, Matrix4, Quaternion, Vector3 } from 'three';
import { LineMaterial } from 'three/addons/lines/LineMaterial.js';
import { LineSegments2 } from 'three/addons/lines/LineSegments2.js';
import { LineSegmentsGeometry } from 'three/addons/lines/LineSegmentsGeometry.js';

const kFrustumDepth_m = 0.3;
export const kLineLayer = 1;  // the picking camera does not see it

export function segments(color, width_px) {
  const material = new LineMaterial({ color, linewidth: width_px, transparent: true });
  const lines = new LineSegments2(new LineSegmentsGeometry(), material);
  lines.layers.set(kLineLayer);
  lines.frustumCulled = false;  // its own bounds are not worth keeping
  lines.visible = false;
  return lines;
}

export function replace(lines, points) {
  lines.geometry.dispose();
  lines.geometry = new LineSegmentsGeometry();
  lines.visible = points.length > 0;
  if (points.length > 0) lines.geometry.setPositions(points);
}

const pairs = (corners, edges) => edges.flatMap(([a, b]) => [...corners[a], ...corners[b]]);

// The four corners of the image at `depth_m` before the camera, and the camera itself.
export function frustum_points({ width, height, fx, fy, cx, cy }, depth_m) {
  const corners = [[0, 0], [width, 0], [width, height], [0, height]].map(([u, v]) => [((u - cx) / fx) * depth_m, ((v - cy) / fy) * depth_m, depth_m]);
  const top = [(corners[0][0] + corners[1][0]) / 2, corners[0][1] - 0.12 * depth_m, depth_m];
  return pairs([...corners, [0, 0, 0], top], [[0, 1], [1, 2], [2, 3], [3, 0], [4, 0], [4, 1], [4, 2], [4, 3], [0, 5], [1, 5]]);
}

export function box_points(min, max) {
  const corners = Array.from({ length: 8 }, (_, i) => [0, 1, 2].map((k) => (i >> k & 1 ? max[k] : min[k])));
  const edges = [];
  for (let i = 0; i < 8; ++i) for (let k = 0; k < 3; ++k) if (!(i >> k & 1)) edges.push([i, i | 1 << k]);
  return pairs(corners, edges);
}

export class Trail {
  group = new Group();
  #path = segments('#2f81c7', 2);
  #frustum = segments('#e08a1e', 2.5);
  #box = segments('#2f81c7', 2);
  #box_behind = segments('#2f81c7', 1.5);  // the part of it that surface hides
  #path_points = 0;

  constructor(camera) {
    camera.layers.enable(kLineLayer);
    this.group.add(this.#path, this.#frustum, this.#box, this.#box_behind);
    Object.assign(this.#box_behind.material, { depthTest: false, opacity: 0.3 });
    this.#frustum.matrixAutoUpdate = false;
  }

  set_colors({ path, frustum, box }) {
    this.#path.material.color.set(path);
    this.#frustum.material.color.set(frustum);
    this.#box.material.color.set(box);
    this.#box_behind.material.color.set(box);
  }

  set path_shown(shown) {
    this.#path.material.visible = shown;
    this.#frustum.material.visible = shown;
  }

  reset() {
    for (const lines of [this.#path, this.#frustum, this.#box, this.#box_behind]) replace(lines, []);
    this.#path_points = 0;
  }

  set_path(places) {
    if (places.length === this.#path_points) return;
    this.#path_points = places.length;
    replace(this.#path, places.slice(1).flatMap((place, i) => [...places[i], ...place]));
  }

  // Returns the camera's pose in the map's axes, or null where there is no frame.
  set_frame(frame) {
    if (!frame || frame.index < 0 || !(frame.camera.width > 0 && frame.camera.fx > 0)) {
      replace(this.#frustum, []);
      return null;
    }
    const { world_from_camera, camera } = frame;
    replace(this.#frustum, frustum_points(camera, kFrustumDepth_m));
    this.#frustum.matrix.set(...world_from_camera);
    this.#frustum.matrixWorldNeedsUpdate = true;
    const position = new Vector3();
    const rotation = new Quaternion();
    new Matrix4().set(...world_from_camera).decompose(position, rotation, new Vector3());
    return { position, rotation };
  }

  // Null takes the box away. Returns it as three.js has it.
  set_box(object) {
    const points = object ? box_points(object.min_m, object.max_m) : [];
    replace(this.#box, points);
    replace(this.#box_behind, points);
    return object ? new Box3(new Vector3(...object.min_m), new Vector3(...object.max_m)) : null;
  }
}
