// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The one material of the surface, and its twin that draws rows of the table of labels instead of colours for picking. Colours are written as they are
// stored (sRGB): no colour management touches what the camera saw. Positions arrive in units of a block; each chunk's matrix
// turns them into metres.
import { DataTexture, DoubleSide, FrontSide, GLSL3, NearestFilter, RGBAFormat, RawShaderMaterial, UnsignedByteType, Vector3 } from 'three';

export const kModes = ['color', 'class', 'panoptic', 'normals', 'confidence'];

const kLookup = `
precision highp float;
precision highp int;
uniform mat4 modelMatrix, viewMatrix, projectionMatrix;
uniform highp sampler2D labels;
in vec4 position;
in vec4 normal;
in vec4 color;
ivec2 texel(int row) { return ivec2(row & 255, row >> 8); }
`;

const kVertex = `${kLookup}
uniform int mode;
uniform vec3 eye;
out vec3 base;
out vec3 toward_eye;
out vec3 facing;
out vec2 shown_and_mark;

// From hardly to well observed: dark violet, blue, green, yellow.
vec3 ramp(float t) {
  vec3 low = mix(vec3(0.24, 0.10, 0.36), vec3(0.16, 0.42, 0.60), clamp(t * 3.0, 0.0, 1.0));
  vec3 middle = mix(low, vec3(0.20, 0.66, 0.50), clamp(t * 3.0 - 1.0, 0.0, 1.0));
  return mix(middle, vec3(0.97, 0.89, 0.36), clamp(t * 3.0 - 2.0, 0.0, 1.0));
}

void main() {
  int row = int(position.w + 0.5);
  vec4 of_class = texelFetch(labels, texel(row), 0);
  vec4 of_object = texelFetch(labels, texel(row) + ivec2(0, 256), 0);
  vec4 world = modelMatrix * vec4(position.xyz, 1.0);
  facing = normalize(mat3(modelMatrix) * normal.xyz + vec3(1e-9));
  toward_eye = eye - world.xyz;
  shown_and_mark = vec2(of_class.a, of_object.a);
  base = mode == 0 ? color.rgb : mode == 1 ? of_class.rgb : mode == 2 ? of_object.rgb : mode == 3 ? facing * 0.5 + 0.5 : ramp(color.a);
  gl_Position = projectionMatrix * viewMatrix * world;
}`;

const kFragment = `
precision highp float;
precision highp int;
uniform int mode;
uniform float dimmed;
uniform vec3 accent, background;
in vec3 base;
in vec3 toward_eye;
in vec3 facing;
in vec2 shown_and_mark;
out vec4 shade;

void main() {
  if (shown_and_mark.x < 0.25) discard;
  vec3 direction = normalize(toward_eye);
  vec3 n = normalize(facing);
  if (!gl_FrontFacing) n = -n;
  float toward = clamp(dot(n, direction), 0.0, 1.0);
  // A lamp at the eye and a sky above: enough to tell surfaces apart, too little to change which colour one sees.
  float light = 0.58 + 0.34 * toward + 0.10 * n.y;
  float strength = mode == 0 ? 0.35 : mode == 3 ? 0.15 : 1.0;
  vec3 lit = base * mix(1.0, light, strength);
  if (!gl_FrontFacing) lit *= 0.38;
  float selected = smoothstep(0.70, 0.90, shown_and_mark.y);
  float hovered = smoothstep(0.25, 0.45, shown_and_mark.y) * (1.0 - selected);
  float rim = pow(1.0 - toward, 2.0);
  lit = mix(lit, mix(background, vec3(dot(lit, vec3(0.3, 0.55, 0.15))), 0.35), dimmed * 0.45 * (1.0 - max(selected, hovered)));
  float faded = 1.0 - smoothstep(0.55, 0.95, shown_and_mark.x);
  lit = mix(lit, mix(background, vec3(dot(lit, vec3(0.3, 0.55, 0.15))), 0.22), faded * (1.0 - 0.5 * max(selected, hovered)));
  lit = mix(lit, accent, selected * (0.18 + 0.55 * rim) + hovered * (0.12 + 0.25 * rim));
  shade = vec4(lit, 1.0);
}`;

// Red and green: the row of the table of labels. Blue and alpha: how far from the eye, in millimetres.
const kPickVertex = `${kLookup}
uniform vec3 eye;
out float shown;
out float distance_m;
flat out int row;
void main() {
  row = int(position.w + 0.5);
  shown = texelFetch(labels, texel(row), 0).a;
  vec4 world = modelMatrix * vec4(position.xyz, 1.0);
  distance_m = length(world.xyz - eye);
  gl_Position = projectionMatrix * viewMatrix * world;
}`;

const kPickFragment = `
precision highp float;
precision highp int;
in float shown;
in float distance_m;
flat in int row;
out vec4 bytes;
void main() {
  if (shown < 0.25) discard;
  int far = min(int(distance_m * 1000.0), 65535);
  bytes = vec4(ivec4(row & 255, row >> 8, far & 255, far >> 8)) / 255.0;
}`;

// Hides figures in the camera view: depth alone.
const kDepthFragment = `
precision highp float;
in float shown;
out vec4 nothing;
void main() {
  if (shown < 0.25) discard;
  nothing = vec4(0.0);
}`;

// The table of labels.js on the graphics card, and both materials that look things up in it.
export class SurfaceMaterial {
  #texture;
  #labels;

  constructor(labels) {
    this.#labels = labels;
    this.#texture = new DataTexture(labels.texels, 256, 512, RGBAFormat, UnsignedByteType);
    this.#texture.magFilter = NearestFilter;
    this.#texture.minFilter = NearestFilter;
    const shared = { labels: { value: this.#texture }, eye: { value: new Vector3() } };
    const look = {
      mode: { value: 0 }, dimmed: { value: 0 }, accent: { value: new Vector3(0.2, 0.5, 0.9) }, background: { value: new Vector3(1, 1, 1) },
    };
    this.seen = new RawShaderMaterial({ glslVersion: GLSL3, vertexShader: kVertex, fragmentShader: kFragment, uniforms: { ...shared, ...look } });
    this.picked = new RawShaderMaterial({ glslVersion: GLSL3, vertexShader: kPickVertex, fragmentShader: kPickFragment, uniforms: shared });
    this.depth = new RawShaderMaterial({ glslVersion: GLSL3, vertexShader: kPickVertex, fragmentShader: kDepthFragment, uniforms: shared, colorWrite: false });
    this.depth.side = DoubleSide;
    this.seen.side = FrontSide;
  }

  set mode(mode) {
    this.seen.uniforms.mode.value = kModes.indexOf(mode);
  }

  // Colours are triples of 0-1.
  set_look({ accent, background }) {
    this.seen.uniforms.accent.value.fromArray(accent);
    this.seen.uniforms.background.value.fromArray(background);
  }

  set back_sides(drawn) {
    this.seen.side = drawn ? DoubleSide : FrontSide;
    this.picked.side = this.seen.side;
    this.seen.needsUpdate = true;
    this.picked.needsUpdate = true;
  }

  get back_sides() {
    return this.seen.side !== FrontSide;
  }

  id_at(row) {
    return this.#labels.id_at(row);
  }

  // Before every drawing.
  prepare(eye) {
    this.seen.uniforms.eye.value.copy(eye);
    this.seen.uniforms.dimmed.value = this.#labels.selected === 0 ? 0 : 1;
    if (!this.#labels.changed) return;
    this.#labels.changed = false;
    this.#texture.needsUpdate = true;
  }
}
