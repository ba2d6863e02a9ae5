// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Finds what is under the pointer: draws the label of one pixel into a target of its own and reads it back.
import { Color, NearestFilter, Vector2, Vector3, WebGLRenderTarget } from 'three';

export class Picking {
  #stage;
  #material;
  #target = new WebGLRenderTarget(1, 1, { minFilter: NearestFilter, magFilter: NearestFilter, generateMipmaps: false });

  constructor(stage, material) {
    this.#stage = stage;
    this.#material = material;
  }

  // {id, place} of the surface at a pixel of the page, `place` in the scene; null where there is none.
  at(x_px, y_px) {
    const { renderer, camera, scene, canvas } = this.#stage;
    const eye = camera.clone();
    eye.layers.set(0);  // the surface only
    eye.setViewOffset(canvas.clientWidth, canvas.clientHeight, x_px - 0.5, y_px - 0.5, 1, 1);
    const { background } = scene;
    this.#material.prepare(camera.position);
    scene.overrideMaterial = this.#material.picked;
    scene.background = null;
    const clear = renderer.getClearColor(new Color());
    const alpha = renderer.getClearAlpha();
    renderer.setClearColor(0, 0);
    renderer.setRenderTarget(this.#target);
    renderer.clear();
    renderer.render(scene, eye);
    const bytes = new Uint8Array(4);
    renderer.readRenderTargetPixels(this.#target, 0, 0, 1, 1, bytes);
    renderer.setRenderTarget(null);
    renderer.setClearColor(clear, alpha);
    scene.overrideMaterial = null;
    scene.background = background;
    return this.#found(bytes, x_px, y_px);
  }

  #found([low, high, near, far], x_px, y_px) {
    const distance_m = (near | far << 8) / 1000;
    if (distance_m === 0) return null;
    const { camera, canvas } = this.#stage;
    const at = new Vector2((x_px / canvas.clientWidth) * 2 - 1, 1 - (y_px / canvas.clientHeight) * 2);
    const ray = new Vector3(at.x, at.y, 0.5).unproject(camera).sub(camera.position).normalize();
    return { id: this.#material.id_at(low | high << 8), place: camera.position.clone().addScaledVector(ray, distance_m) };
  }
}
