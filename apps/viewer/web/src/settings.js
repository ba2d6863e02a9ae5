// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Settings that the page remembers in this browser. A browser that keeps nothing is fine.

const kPrefix = 'panoptic.';

export function recall(name, otherwise) {
  try {
    const text = localStorage.getItem(kPrefix + name);
    return text === null ? otherwise : JSON.parse(text);
  } catch {
    return otherwise;
  }
}

export function remember(name, value) {
  try {
    localStorage.setItem(kPrefix + name, JSON.stringify(value));
  } catch {
    // private windows refuse: then it holds until the page is closed
  }
}
