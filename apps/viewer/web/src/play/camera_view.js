// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The recorded image of one frame with the figures in it, from where its camera was. The map's surface is drawn into the depth
// alone: what is in front of a figure in the map hides it in the picture.
import { Matrix4, Mesh, OrthographicCamera, PerspectiveCamera, PlaneGeometry, Scene, MeshBasicMaterial, SRGBColorSpace, Texture } from 'three';

const kNear_m = 0.05;
const kFar_m = 60;
export const kFiguresLayer = 2;

// OpenGL's projection of a pinhole camera whose pixel centres are at whole numbers.
export function projection_of({ width, height, fx, fy, cx, cy }) {
  const [n, f] = [kNear_m, kFar_m];
  return new Matrix4().set(
    (2 * fx) / width, 0, 1 - (2 * cx + 1) / width, 0,
    0, (2 * fy) / height, (2 * cy + 1) / height - 1, 0,
    0, 0, -(f + n) / (f - n), (-2 * f * n) / (f - n),
    0, 0, -1, 0);
}

export class CameraView {
  #stage;
  #surface;
  #depth;
  #camera = new PerspectiveCamera();
  #back = new Scene();
  #flat = new OrthographicCamera(-1, 1, 1, -1, 0, 1);
  #texture = new Texture();
  #frame = null;

  // depth: a material that draws the surface's depth and nothing else.
  constructor(stage, surface, depth) {
    this.#stage = stage;
    this.#surface = surface;
    this.#depth = depth;
    this.#texture.colorSpace = SRGBColorSpace;
    this.#texture.flipY = false;
    this.#texture.generateMipmaps = false;
    const paper = new MeshBasicMaterial({ map: this.#texture, depthTest: false, depthWrite: false, toneMapped: false });
    this.#back.add(new Mesh(new PlaneGeometry(2, 2), paper));
    this.#camera.matrixAutoUpdate = false;
    this.#camera.layers.enable(kFiguresLayer);
  }

  get frame() {
    return this.#frame;
  }

  show(frame) {
    this.#frame?.image.close();
    this.#frame = frame;
    this.#texture.dispose();
    this.#texture.image = frame.image;
    this.#texture.needsUpdate = true;
    this.#camera.projectionMatrix.copy(projection_of(frame.camera));
    this.#camera.projectionMatrixInverse.copy(this.#camera.projectionMatrix).invert();
    this.#stage.invalidate();
  }

  // Where the picture lies on the canvas: as large as it fits; pixels of the page from the upper left corner.
  box(width, height) {
    const { camera } = this.#frame;
    const scale = Math.min(width / camera.width, height / camera.height);
    const size = { width: camera.width * scale, height: camera.height * scale };
    return { x: (width - size.width) / 2, y: (height - size.height) / 2, ...size };
  }

  // The ray of a point of the canvas: {camera, x, y} with x, y from -1 to 1; null beside the picture.
  aim(x_px, y_px, width, height) {
    const box = this.box(width, height);
    const [x, y] = [(2 * (x_px - box.x)) / box.width - 1, 1 - (2 * (y_px - box.y)) / box.height];
    return Math.abs(x) <= 1 && Math.abs(y) <= 1 ? { camera: this.#camera, x, y } : null;
  }

  // Instead of the stage's own drawing.
  draw(renderer, scene) {
    const { clientWidth: width, clientHeight: height } = this.#stage.canvas;
    const box = this.box(width, height);
    this.#pose();
    const { background } = scene;
    renderer.setRenderTarget(null);
    renderer.setClearColor(background, 1);
    renderer.setViewport(0, 0, width, height);
    renderer.clear();
    renderer.autoClear = false;
    scene.background = null;
    renderer.setViewport(box.x, height - box.y - box.height, box.width, box.height);
    renderer.render(this.#back, this.#flat);
    renderer.clearDepth();
    const meshes = this.#surface.group.children;
    const before = meshes.map((mesh) => mesh.material);
    for (const mesh of meshes) [mesh.material, mesh.renderOrder] = [this.#depth, -1];
    renderer.render(scene, this.#camera);
    meshes.forEach((mesh, i) => { [mesh.material, mesh.renderOrder] = [before[i], 0]; });
    scene.background = background;
    renderer.autoClear = true;
    renderer.setViewport(0, 0, width, height);
  }

  // The recording's camera looks along +z with y down; three's along -z with y up.
  #pose() {
    const rows = this.#frame.world_from_camera;
    const pose = new Matrix4().set(...rows).multiply(new Matrix4().makeScale(1, -1, -1));
    this.#camera.matrix.multiplyMatrices(this.#stage.map.matrixWorld, pose);
    this.#camera.matrixWorld.copy(this.#camera.matrix);
    this.#camera.matrixWorldInverse.copy(this.#camera.matrixWorld).invert();
    this.#camera.matrixWorld.decompose(this.#camera.position, this.#camera.quaternion, this.#camera.scale);
  }

  // The picture in the size of the recorded image.
  picture() {
    this.#stage.draw_now();
    const { canvas } = this.#stage;
    const ratio = canvas.width / canvas.clientWidth;
    const box = this.box(canvas.clientWidth, canvas.clientHeight);
    const { width, height } = this.#frame.camera;
    const paper = Object.assign(document.createElement('canvas'), { width, height });
    paper.getContext('2d').drawImage(canvas, box.x * ratio, box.y * ratio, box.width * ratio, box.height * ratio, 0, 0, width, height);
    return new Promise((resolve) => { paper.toBlob(resolve, 'image/png'); });
  }
}
