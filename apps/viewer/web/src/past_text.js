// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A look back in time in words.
import { duration_text } from './timeline.js';

const kLongest_s = 24 * 3600;  // later stamps count from somewhere else than the beginning of the recording

// "7.4 s", "31 s", "2:05"; of a recording with the stamps of a clock "+31 s", from its beginning on.
export function moment_text(time_s, start_s = 0) {
  const [sign, shown_s] = start_s > kLongest_s ? ['+', time_s - start_s] : ['', time_s];
  return sign + (shown_s < 60 ? `${Number(shown_s.toFixed(1))} s` : duration_text(shown_s));
}

// "chair, gone at 31 s"
export function ghost_text(class_name, { gone_s, moved_to }, start_s = 0) {
  return `${class_name}, ${moved_to === null ? 'gone' : 'moved'} at ${moment_text(gone_s, start_s)}`;
}

const counted = (count, one, many = `${one}s`) => (count === 0 ? [] : [`${count.toLocaleString('en')} ${count === 1 ? one : many}`]);

// The time that is shown, counted; `time_s` null: now.
export function time_text(past, time_s) {
  if (time_s !== null) return [`${past.there_at(time_s).length.toLocaleString('en')} there`, ...counted(past.moving(time_s).length, 'moving', 'moving')].join(' · ');
  const of_kind = (kind) => past.changes().filter((change) => change.kind === kind).length;
  return [...['came', 'gone', 'moved'].flatMap((kind) => counted(of_kind(kind), kind, kind)), ...counted(past.tracks.length, 'track')].join(' · ');
}

// The part that this page was not sent; empty if it has everything.
export function left_out_text({ objects, tracks, boxes, forgotten_boxes }) {
  const parts = [...counted(objects, 'object'), ...counted(tracks, 'track'), ...counted(boxes, 'box', 'boxes'), ...counted(forgotten_boxes, 'old box', 'old boxes')];
  return parts.length === 0 ? '' : `without ${parts.join(', ')}`;
}
