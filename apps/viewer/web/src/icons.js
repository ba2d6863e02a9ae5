// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Line icons on a grid of 20, drawn in the colour of the text.

const kPaths = {
  orbit: 'M10 4a6 2.4 0 1 0 .01 0M10 4a2.4 6 0 1 1-.01 0M10 4v0',
  walk: 'M11 3.5a1 1 0 1 0 .01 0M10.5 7l-2 4.5L11 14v4M8.5 11.5L6.5 17M10.5 7L14 9.5M10.5 7L7.5 8 6.5 10.5',
  follow: 'M3 6h9v8H3zM12 9l5-2.5v7L12 11',
  home: 'M3.5 9.5 10 4l6.5 5.5M5.5 8.5V16h9V8.5',
  path: 'M4 16c0-5 5-2 6-6s1-6 6-6M4 16h0M16 4h0',
  tag: 'M3 4h6l8 8-5 5-8-8zM6.5 7.5h.01',
  back: 'M4 4h8v8H4zM8 12v4h8V8h-4',
  camera: 'M3 6.5h3.5L8 4.5h4l1.5 2H17V16H3zM10 8.5a2.5 2.5 0 1 0 .01 0',
  download: 'M10 3v9M6 8.5l4 4 4-4M4 16.5h12',
  theme: 'M10 3a7 7 0 1 0 .01 0M10 3v14',
  help: 'M7.5 7.5a2.5 2.5 0 1 1 3.5 2.3c-.7.3-1 .8-1 1.7M10 14.5h.01M10 2.5a7.5 7.5 0 1 0 .01 0',
  eye: 'M2.5 10S5 5 10 5s7.5 5 7.5 5-2.5 5-7.5 5-7.5-5-7.5-5M10 7.8a2.2 2.2 0 1 0 .01 0',
  eye_off: 'M2.5 10S5 5 10 5s7.5 5 7.5 5-2.5 5-7.5 5-7.5-5-7.5-5M4 16.5 16 3.5',
  list: 'M4 5h12M4 10h12M4 15h12',
  panel: 'M3 4h14v12H3zM12.5 4v12',
  close: 'M5 5l10 10M15 5 5 15',
  person: 'M10 3a2 2 0 1 0 .01 0M6.5 12V9.5A1.5 1.5 0 0 1 8 8h4a1.5 1.5 0 0 1 1.5 1.5V12M8.3 8.5V17M11.7 8.5V17',
  insect: 'M10 6c2 0 3 2 3 5s-1 5.500-3 5.500-3-2.500-3-5.500 1-5 3-5M10 6V16M7.200 9 4 7.500M7 11.500H3.500M7.200 14 4.500 16M12.800 9 16 7.500M13 11.500h3.500M12.800 14l2.700 2M8.700 6 7.500 3.500M11.300 6l1.200-2.500',
  trash: 'M4.500 6h11M8 6V4h4v2M6 6l.7 10.500h6.600L14 6M8.700 9v4.500M11.300 9v4.500',
  before: 'M13 4.500 7 10l6 5.500M5 4.500v11',
  next: 'M7 4.500 13 10l-6 5.500M15 4.500v11',
  play: 'M6.500 4l9 6-9 6z',
  pause: 'M7.500 4.500v11M12.500 4.500v11',
  rings: 'M10 9a1 1 0 1 0 .01 0M10 5.500a4.500 4.500 0 1 0 .01 0M10 2a8 8 0 1 0 .01 0',
  target: 'M10 5a5 5 0 1 0 .01 0M10 2v4M10 14v4M2 10h4M14 10h4',
};

export function icon(name) {
  const svg = document.createElementNS('http://www.w3.org/2000/svg', 'svg');
  svg.setAttribute('viewBox', '0 0 20 20');
  svg.setAttribute('class', 'icon');
  svg.setAttribute('aria-hidden', 'true');
  const path = document.createElementNS('http://www.w3.org/2000/svg', 'path');
  path.setAttribute('d', kPaths[name]);
  svg.append(path);
  return svg;
}
