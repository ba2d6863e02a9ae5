// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Lengths of a figure's body in metres: shares of its height, after the proportions of adults.

// A number in [0, 1) for each call, the same row of numbers for the same seed (mulberry32).
export function random_of(seed) {
  let state = seed >>> 0;
  return () => {
    state = (state + 0x6d2b79f5) >>> 0;
    let t = Math.imul(state ^ (state >>> 15), 1 | state);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    return ((t ^ (t >>> 14)) >>> 0) / 4294967296;
  };
}

export function shape_of(height_m) {
  const share = (part) => part * height_m;
  return {
    height: height_m,
    thigh: share(0.24), shin: share(0.238), ankle: share(0.045),  // the ankle's height above the sole
    hip: share(0.513),          // the pelvis above the floor, standing with knees not quite straight
    hip_half: share(0.052),
    waist: share(0.055),        // from the pelvis up to where the back bends
    chest: share(0.222),        // from there to the height of the shoulders
    shoulder_half: share(0.108),
    neck: share(0.048), head: share(0.078),  // from the shoulders to the chin; radius of the head
    upper_arm: share(0.165), forearm: share(0.15), hand: share(0.032),
    foot: share(0.15), foot_half: share(0.028),
    buttocks: share(0.058),     // from the pelvis down to what one sits on
    back: share(0.07),          // from the pelvis to what one lies on
  };
}

// Looks of the figures, taken in turn: shirt, trousers, shoes, skin, hair.
export const kOutfits = [
  { shirt: '#d9693c', trousers: '#34465c', shoes: '#f0ece4', skin: '#e3ac86', hair: '#3c2a20' },
  { shirt: '#2f8f83', trousers: '#4a4038', shoes: '#22262b', skin: '#8d5a3c', hair: '#17130f' },
  { shirt: '#e4b23c', trousers: '#3f5f86', shoes: '#7b3f2c', skin: '#f0c6a4', hair: '#b5672f' },
  { shirt: '#6a5fb0', trousers: '#2b2f38', shoes: '#d8d3ca', skin: '#c68a60', hair: '#241a14' },
  { shirt: '#c74a62', trousers: '#586a5a', shoes: '#2b2b2b', skin: '#f2d0b4', hair: '#d9c08a' },
  { shirt: '#4f83c4', trousers: '#6d5a48', shoes: '#efe9df', skin: '#a8714b', hair: '#2d211a' },
];
