// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The bar that chooses a time of the recording, and plays it. Its right end is now.
import { element, set_text } from './dom.js';
import { icon } from './icons.js';
import { moment_text } from './past_text.js';

const kSteps = 2000;
const kLongestPlay_s = 30;

// The seconds of the recording that a second of playing shows.
export function playing_speed(duration_s) {
  return Math.max(1, duration_s / kLongestPlay_s);
}

export class TimeSlider {
  playing = false;
  time_s = null;  // null: now
  #root;
  #stage;
  #on_time;
  #past = null;
  #play = element('button', { type: 'button', class: 'icon-button', on: { click: () => this.toggle() } });
  #clock = element('output', { class: 'tabular' });
  #slider = element('input', { type: 'range', min: 0, max: kSteps, step: 1, 'aria-label': 'Time', on: { input: () => this.#on_slider() } });
  #marks = element('div', { class: 'marks', 'aria-hidden': 'true' });
  #note = element('span', { class: 'muted tabular note' });
  #missing = element('span', { class: 'muted missing' });

  // on_time(time_s) with null for now.
  constructor(root, stage, on_time) {
    this.#root = root;
    this.#stage = stage;
    this.#on_time = on_time;
    root.append(this.#play, element('div', { class: 'scale-of-time' }, this.#marks, this.#slider), this.#clock, this.#note, this.#missing);
  }

  // Null takes it away.
  open(past) {
    this.#past = past;
    this.playing = false;
    this.#root.hidden = past === null;
    document.body.classList.toggle('has-past', past !== null);
    if (past === null) return;
    const share = (time_s) => `${(100 * (time_s - past.start_s) / this.#duration_s).toFixed(2)}%`;
    const places = new Set(past.changes().map(({ time_s, kind }) => `${kind} ${share(time_s)}`));  // two in one place look like one
    this.#marks.replaceChildren(...past.restless().map(([from, to]) => this.#mark('restless', share(from), share(past.start_s + to - from))),
      ...[...places].map((place) => this.#mark(...place.split(' '))));
    this.set(null);
  }

  say(note, missing) {
    set_text(this.#note, note);
    set_text(this.#missing, missing);
    this.#slider.setAttribute('aria-valuetext', `${this.#clock.textContent}: ${note}`);
  }

  // From the beginning if it is at its end.
  toggle() {
    if (this.#past === null) return;
    this.playing = !this.playing;
    if (this.playing && this.time_s === null) this.set(this.#past.start_s);
    this.#show_button();
    if (this.playing) this.#stage.animate((passed_s) => this.#advance(passed_s));
  }

  set(time_s) {
    const { start_s, end_s } = this.#past;
    this.time_s = time_s === null || time_s >= end_s ? null : Math.max(start_s, time_s);
    if (this.time_s === null) this.playing = false;
    this.#slider.value = this.time_s === null ? kSteps : Math.min(kSteps - 1, Math.round(kSteps * (this.time_s - start_s) / this.#duration_s));
    set_text(this.#clock, this.time_s === null ? 'now' : moment_text(this.time_s, start_s));
    this.#clock.title = this.time_s === null ? '' : `query --when ${this.time_s.toFixed(2)}`;
    this.#root.classList.toggle('earlier', this.time_s !== null);
    this.#show_button();
    this.#on_time(this.time_s);
  }

  get #duration_s() {
    return Math.max(1e-6, this.#past.end_s - this.#past.start_s);
  }

  #mark(kind, left, width) {
    const mark = element('i', { class: kind });
    mark.style.left = left;
    if (width) mark.style.width = width;
    return mark;
  }

  #on_slider() {
    const place = Number(this.#slider.value);
    this.playing = false;
    this.set(place >= kSteps ? null : this.#past.start_s + this.#duration_s * place / kSteps);
  }

  // Before every picture; true as long as it goes on.
  #advance(passed_s) {
    if (!this.playing || this.#past === null) return false;
    this.set(this.time_s + passed_s * playing_speed(this.#duration_s));
    return this.playing;
  }

  #show_button() {
    const label = this.playing ? 'Pause' : 'Play what happened';
    if (this.#play.title === `${label} (J)`) return;
    this.#play.replaceChildren(icon(this.playing ? 'pause' : 'play'));
    this.#play.title = `${label} (J)`;
    this.#play.setAttribute('aria-label', label);
  }
}
