// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// How the run goes: rates, memory, dropped frames, and the time of every stage, each with its last minutes as a line.
import { element, set_text } from './dom.js';
import { History } from './history.js';

const kSpan_s = 180;
const kOrder = ['read', 'decode', 'semantic', 'instance', 'predict', 'fusion', 'register', 'reference', 'track', 'integrate', 'regularize', 'objects', 'mesh', 'publish'];

export function number_text(value) {
  if (!Number.isFinite(value)) return '–';
  if (value >= 100 || Number.isInteger(value)) return Math.round(value).toLocaleString('en');
  return value.toFixed(value >= 10 ? 1 : 2);
}

// For small print.
export function short_text(value) {
  return value >= 9.95 ? Math.round(value).toLocaleString('en') : `${Math.round(10 * value) / 10}`;
}

export function duration_text(seconds) {
  const whole = Math.max(0, Math.floor(seconds));
  const pad = (n) => `${n}`.padStart(2, '0');
  const hours = Math.floor(whole / 3600);
  return `${hours > 0 ? `${hours}:${pad(Math.floor(whole / 60) % 60)}` : Math.floor(whole / 60)}:${pad(whole % 60)}`;
}

export class Timeline {
  #grid;
  #tiles = new Map();
  #history = new History(kSpan_s);

  constructor(root) {
    this.#grid = element('div', { class: 'tiles' });
    root.append(this.#grid);
    new ResizeObserver(() => this.redraw()).observe(root);
  }

  reset() {
    this.#history.clear();
    this.#tiles.clear();
    this.#grid.replaceChildren();
  }

  update(run) {
    const now_s = performance.now() / 1000;
    const rate = (hz) => (run.finished ? NaN : hz);  // nothing comes any more: not zero, but no rate
    const dropped = Object.entries(run.dropped);
    const all = dropped.reduce((sum, [, count]) => sum + count, 0);
    this.#show('geometry', 'Geometry', now_s, rate(run.geometry_hz), 'Hz', `${run.frames_used.toLocaleString('en')} frames`);
    this.#show('labels', 'Labels', now_s, rate(run.label_hz), 'Hz', `${run.frames_labelled.toLocaleString('en')} frames`);
    this.#show('memory', 'Memory', now_s, run.memory_mb, 'MB', 'of the process');
    this.#show('dropped', 'Dropped', now_s, all, '', dropped.filter(([, n]) => n > 0).map(([stage, n]) => `${stage} ${n}`).join(', ') || 'none');
    const rank = ([name]) => (kOrder.includes(name) ? kOrder.indexOf(name) : kOrder.length);
    for (const [name, time] of Object.entries(run.stages).sort((a, b) => rank(a) - rank(b) || a[0].localeCompare(b[0], 'en'))) {
      this.#show(`stage ${name}`, name, now_s, time.last_ms, 'ms', `p50 ${short_text(time.p50_ms)} · p95 ${short_text(time.p95_ms)}`, time.p95_ms);
    }
    this.redraw();
  }

  redraw() {
    const style = getComputedStyle(document.documentElement);
    const colors = { line: style.getPropertyValue('--accent'), fill: style.getPropertyValue('--accent-soft'), guide: style.getPropertyValue('--line') };
    for (const [name, tile] of this.#tiles) draw_line(tile.canvas, this.#history.points(name), tile.guide, colors);
  }

  #show(key, title, now_s, value, unit, note, guide) {
    this.#history.add(key, now_s, value);
    let tile = this.#tiles.get(key);
    if (!tile) this.#tiles.set(key, tile = this.#made(key, title, unit));
    set_text(tile.value, number_text(value));
    set_text(tile.note, note);
    tile.guide = guide;
  }

  #made(key, title, unit) {
    const tile = { value: element('strong', { class: 'tabular' }), note: element('span', { class: 'note muted tabular' }), canvas: element('canvas', { 'aria-hidden': 'true' }) };
    this.#grid.append(element('section', { class: key.startsWith('stage ') ? 'tile stage' : 'tile', 'aria-label': title },
      element('header', {}, element('h3', { text: title }), element('span', {}, tile.value, ' ', element('span', { class: 'muted', text: unit }))), tile.canvas, tile.note));
    return tile;
  }
}

// Time runs to the right, now is at the edge; zero is the lower edge, the guide (p95) a thin line.
function draw_line(canvas, points, guide, colors) {
  const { clientWidth: width, clientHeight: height } = canvas;
  if (width === 0 || height === 0) return;
  const ratio = window.devicePixelRatio;
  if (canvas.width !== Math.round(width * ratio)) canvas.width = Math.round(width * ratio);
  if (canvas.height !== Math.round(height * ratio)) canvas.height = Math.round(height * ratio);
  const context = canvas.getContext('2d');
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  if (points.length === 0) return;
  const now_s = points.at(-1)[0];
  const span_s = Math.min(kSpan_s, Math.max(20, now_s - points[0][0]));
  const top = 1.12 * Math.max(guide ?? 0, ...points.map(([, value]) => value), 1e-6);
  const x = (time_s) => width * (1 - (now_s - time_s) / span_s);
  const y = (value) => height - 1 - (height - 2) * (value / top);
  if (guide) {
    context.strokeStyle = colors.guide;
    context.strokeRect(-1, Math.round(y(guide)) + 0.5, width + 2, height * 2);
  }
  context.beginPath();
  points.forEach(([time_s, value], i) => (i === 0 ? context.moveTo(x(time_s), y(value)) : context.lineTo(x(time_s), y(value))));
  context.strokeStyle = colors.line;
  context.lineWidth = 1.5;
  context.lineJoin = 'round';
  context.stroke();
  context.lineTo(width, height);
  context.lineTo(x(points[0][0]), height);
  context.fillStyle = colors.fill;
  context.fill();
}
