// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Finds what is under the pointer: draws the label of one pixel into a target of its own and reads it back.
import { Color, Matrix4, NearestFilter, Vector2, Vector3, WebGLRenderTarget } from 'three';

// Makes the one pixel at `at` (-1 to 1) fill the view of a camera whose projection was given as a matrix.
function narrow(eye, at, canvas) {
  const [sx, sy] = [canvas.clientWidth, canvas.clientHeight];
  eye.projectionMatrix.premultiply(new Matrix4().set(sx, 0, 0, -sx * at.x, 0, sy, 0, -sy * at.y, 0, 0, 1, 0, 0, 0, 0, 1));
}

export class Picking {
  #stage;
  #material;
  #target = new WebGLRenderTarget(1, 1, { minFilter: NearestFilter, magFilter: NearestFilter, generateMipmaps: false });

  constructor(stage, material) {
    this.#stage = stage;
    this.#material = material;
  }

  // {id, place} of the surface at a pixel of the page (or where `film` of CameraView.aim says), `place` in the scene; null where there is none.
  at(x_px, y_px, film = null) {
    const { renderer, scene, canvas } = this.#stage;
    const camera = film?.camera ?? this.#stage.camera;
    const at = film ? new Vector2(film.x, film.y) : new Vector2((x_px / canvas.clientWidth) * 2 - 1, 1 - (y_px / canvas.clientHeight) * 2);
    const eye = camera.clone();
    eye.layers.set(0);  // the surface only
    if (film) narrow(eye, at, canvas);
    else eye.setViewOffset(canvas.clientWidth, canvas.clientHeight, x_px - 0.5, y_px - 0.5, 1, 1);
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
    return this.#found(bytes, camera, at);
  }

  #found([low, high, near, far], camera, at) {
    const distance_m = (near | far << 8) / 1000;
    if (distance_m === 0) return null;
    const ray = new Vector3(at.x, at.y, 0.5).unproject(camera).sub(camera.position).normalize();
    return { id: this.#material.id_at(low | high << 8), place: camera.position.clone().addScaledVector(ray, distance_m) };
  }
}
