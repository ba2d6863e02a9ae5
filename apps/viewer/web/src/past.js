// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The answer of /api/history, as docs/viewer_protocol.md draws it, and what it says of a time. Nothing here knows about drawing.
export const kMost = { objects: 20000, tracks: 1000, boxes: 20000 };  // the server's limits
const kNumbersOfBox = 7;  // time, lowest corner, highest corner
const kLowestWithin_s = 0.5;
const kLift_m = 0.03;  // lines that lie in the floor would flicker

function refuse(what) {
  throw new Error(`/api/history: ${what}`);
}

const is_id = (value) => Number.isInteger(value) && value >= 0 && value <= 0xffffffff;
const is_corner = (value) => Array.isArray(value) && value.length === 3 && value.every(Number.isFinite);

function object_in(entry) {
  const { id, class_id, color, min_m, max_m, first_s, gone_s, moved_to } = entry;
  const sound = is_id(id) && is_id(class_id) && Array.isArray(color) && color.length === 3 && is_corner(min_m) && is_corner(max_m)
    && Number.isFinite(first_s) && (gone_s === null || Number.isFinite(gone_s)) && (moved_to === null || is_id(moved_to));
  return sound ? entry : refuse('an object is not as documented');
}

function track_in({ id, class_id, boxes }) {
  const sound = is_id(id) && is_id(class_id) && Array.isArray(boxes) && boxes.length > 0 && boxes.length % kNumbersOfBox === 0 && boxes.every(Number.isFinite);
  if (!sound) refuse('a track is not as documented');
  const list = [];
  for (let at = 0; at < boxes.length; at += kNumbersOfBox) list.push({ time_s: boxes[at], min_m: boxes.slice(at + 1, at + 4), max_m: boxes.slice(at + 4, at + 7) });
  return { id, class_id, boxes: list };
}

// The rule of panoptic query --when: seen by that time, and not yet known to be gone.
export function was_there(object, time_s) {
  return object.first_s <= time_s && (object.gone_s === null || object.gone_s > time_s);
}

// Where the track is at a time, between the boxes around it; null before its first one and after its last one.
export function box_at({ boxes }, time_s) {
  const next = boxes.findIndex((box) => box.time_s >= time_s);
  if (next < 0 || (next === 0 && boxes[0].time_s > time_s)) return null;
  if (next === 0) return boxes[0];
  const [before, after] = [boxes[next - 1], boxes[next]];
  const share = (time_s - before.time_s) / Math.max(after.time_s - before.time_s, 1e-9);
  const between = (name) => before[name].map((value, k) => value + share * (after[name][k] - value));
  return { time_s, min_m: between('min_m'), max_m: between('max_m') };
}

// The middle of a box, moved along `up` to its lowest (-1) or highest (+1) side.
export function side_of({ min_m, max_m }, up, sign) {
  const half = up.reduce((sum, u, k) => sum + Math.abs(u) * (max_m[k] - min_m[k]) / 2, 0);
  return up.map((u, k) => (min_m[k] + max_m[k]) / 2 + sign * half * u);
}

const height_of = (place, up) => place.reduce((sum, c, k) => sum + c * up[k], 0);

// A place on the floor for each box of a track: below its middle, at the lowest that is seen of it around that time, since feet are
// not always in the picture.
export function floor_places({ boxes }, up) {
  const places = boxes.map((box) => side_of(box, up, -1));
  const heights = places.map((place) => height_of(place, up));
  let from = 0;
  let to = 0;
  return boxes.map(({ time_s }, i) => {
    while (boxes[from].time_s < time_s - kLowestWithin_s) ++from;
    while (to < boxes.length && boxes[to].time_s <= time_s + kLowestWithin_s) ++to;
    const lowest = Math.min(...heights.slice(from, to));
    return places[i].map((c, k) => c + (lowest - heights[i] + kLift_m) * up[k]);
  });
}

export class Past {
  start_s;
  end_s;
  objects;
  tracks;
  left_out;  // {objects, tracks, boxes, forgotten_boxes}
  #by_id;

  // Throws Error if the message is not as documented.
  constructor({ start_s, end_s, objects, tracks, left_out }) {
    if (!Number.isFinite(start_s) || !Number.isFinite(end_s) || end_s < start_s) refuse('its times are none');
    if (!Array.isArray(objects) || !Array.isArray(tracks) || objects.length > kMost.objects || tracks.length > kMost.tracks) refuse('too many objects or tracks');
    this.start_s = start_s;
    this.end_s = end_s;
    this.objects = objects.map(object_in);
    this.tracks = tracks.map(track_in);
    if (this.tracks.reduce((sum, { boxes }) => sum + boxes.length, 0) > kMost.boxes) refuse('too many boxes');
    this.left_out = left_out;
    this.#by_id = new Map(objects.map((object) => [object.id, object]));
  }

  there_at(time_s) {
    return this.objects.filter((object) => was_there(object, time_s));
  }

  // Objects that are in the map and were not there yet.
  not_yet(time_s) {
    return new Set(this.objects.filter((object) => object.gone_s === null && object.first_s > time_s).map(({ id }) => id));
  }

  // Objects that were there and are not in the map any more.
  ghosts(time_s) {
    return this.there_at(time_s).filter((object) => object.gone_s !== null);
  }

  // Objects that were there by that time and are elsewhere now: [{from, to}]. One that is gone from where it was moved to is nowhere.
  moves(time_s) {
    return this.objects.filter((object) => object.moved_to !== null && object.first_s <= time_s)
      .map((from) => ({ from, to: this.#last_place(from) })).filter(({ to }) => to !== null);
  }

  // The object as which one is in the map now; null if there is none.
  #last_place(object) {
    const met = new Set();
    let last = object;
    while (last && last.moved_to !== null && !met.has(last.id)) {
      met.add(last.id);
      last = this.#by_id.get(last.moved_to);
    }
    return last && last.gone_s === null ? last : null;
  }

  // Whoever moves at that time: [{track, box}].
  moving(time_s) {
    return this.tracks.map((track) => ({ track, box: box_at(track, time_s) })).filter(({ box }) => box !== null);
  }

  // The tracks as pairs of places on the floor, ascending by the time of the second one: {places, times}.
  segments(up, is_shown = () => true) {
    const all = this.tracks.filter(is_shown).flatMap((track) => {
      const places = floor_places(track, up);
      return places.slice(1).map((place, i) => ({ time_s: track.boxes[i + 1].time_s, ends: [...places[i], ...place] }));
    }).sort((a, b) => a.time_s - b.time_s);
    return { places: all.flatMap(({ ends }) => ends), times: all.map(({ time_s }) => time_s) };
  }

  // When something changed, ascending: [{time_s, kind}], kind is came, gone or moved.
  changes() {
    const of_object = ({ appeared, moved_from, moved_to, first_s, gone_s }) => [
      ...(gone_s === null ? [] : [{ time_s: gone_s, kind: moved_to === null ? 'gone' : 'moved' }]),
      ...(appeared && (moved_from ?? null) === null ? [{ time_s: first_s, kind: 'came' }] : []),
    ];
    return this.objects.flatMap(of_object).sort((a, b) => a.time_s - b.time_s);
  }

  // The times in which something moved, as few stretches: [[from, to]].
  restless() {
    const joined = [];
    for (const [from, to] of this.tracks.map(({ boxes }) => [boxes[0].time_s, boxes.at(-1).time_s]).sort((a, b) => a[0] - b[0])) {
      if (joined.length > 0 && from <= joined.at(-1)[1]) joined.at(-1)[1] = Math.max(joined.at(-1)[1], to);
      else joined.push([from, to]);
    }
    return joined;
  }
}

// How many of the ascending times have come.
export function count_until(times, time_s) {
  let [low, high] = [0, times.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (times[middle] <= time_s) low = middle + 1;
    else high = middle;
  }
  return low;
}
