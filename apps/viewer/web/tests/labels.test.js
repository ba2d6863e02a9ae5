// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { kFaded, kRows, kSelected, kUnknownColor, Labels } from '../src/labels.js';

const kScene = {
  first_thing: 41,
  classes: [{ id: 3, name: 'wall', is_thing: false, color: [1, 2, 3] }, { id: 12, name: 'chair', is_thing: true, color: [4, 5, 6] },
    { id: 13, name: 'table', is_thing: true, color: [7, 8, 9] }],
};
const chair = { id: 57, class_id: 12, name: 'chair_57', color: [10, 20, 30] };

const texel = (labels, row) => [...labels.texels.slice(4 * row, 4 * row + 4)];
const class_texel = (labels, id) => texel(labels, labels.row_of(id));
const object_texel = (labels, id) => texel(labels, kRows + labels.row_of(id));

function labelled() {
  const labels = new Labels();
  labels.reset(kScene);
  labels.set_objects([chair]);
  for (const id of [57, 900]) labels.take(id);
  return labels;
}

test('Labels: stuff has the colour of its class, things their own', () => {
  const labels = labelled();
  assert.deepEqual(class_texel(labels, 3), [1, 2, 3, 255]);
  assert.deepEqual(object_texel(labels, 3), [1, 2, 3, 0]);
  assert.deepEqual(class_texel(labels, 57), [4, 5, 6, 255]);
  assert.deepEqual(object_texel(labels, 57), [10, 20, 30, 0]);
});

test('Labels: what nobody knows is grey', () => {
  const labels = labelled();
  for (const id of [0, 20, 900]) {
    assert.deepEqual(class_texel(labels, id), [...kUnknownColor, 255]);
    assert.deepEqual(object_texel(labels, id), [...kUnknownColor, 0]);
  }
  assert.equal(labels.name_of(900), 'unknown_900');
});

test('Labels: a new class of an object needs only the table', () => {
  const labels = labelled();
  labels.changed = false;
  labels.set_objects([{ ...chair }]);
  assert.equal(labels.changed, false);
  labels.set_objects([{ ...chair, class_id: 13 }]);
  assert.equal(labels.changed, true);
  assert.deepEqual(class_texel(labels, 57), [7, 8, 9, 255]);
});

test('Labels: an object that is gone is unknown again', () => {
  const labels = labelled();
  labels.set_objects([]);
  assert.deepEqual(class_texel(labels, 57), [...kUnknownColor, 255]);
});

test('Labels: hiding a class hides its objects and nothing else', () => {
  const labels = labelled();
  labels.show_class(12, false);
  assert.deepEqual([class_texel(labels, 57)[3], class_texel(labels, 3)[3]], [0, 255]);
  labels.set_objects([{ ...chair, class_id: 13 }]);
  assert.equal(class_texel(labels, 57)[3], 255);
});

test('Labels: a hidden object stays hidden when its class is shown', () => {
  const labels = labelled();
  labels.show_object(57, false);
  labels.show_class(12, false);
  labels.show_class(12, true);
  assert.equal(labels.is_object_shown(57), false);
  assert.equal(class_texel(labels, 57)[3], 0);
});

test('Labels: marks one object at a time, and never what is unknown', () => {
  const labels = labelled();
  labels.select(57);
  assert.equal(object_texel(labels, 57)[3], kSelected);
  labels.select(3);
  assert.deepEqual([object_texel(labels, 57)[3], object_texel(labels, 3)[3]], [0, kSelected]);
  labels.select(0);
  assert.deepEqual([object_texel(labels, 3)[3], object_texel(labels, 0)[3]], [0, 0]);
});

test('Labels: ids beyond 16 bits have rows of their own, which are given anew when nothing shows them', () => {
  const labels = labelled();
  const far = { id: 4_000_000_000, class_id: 13, name: 'table_4000000000', color: [9, 9, 9] };
  const row = labels.take(far.id);
  assert.equal(labels.take(far.id), row);
  assert.ok(row < kRows && row !== labels.row_of(57));
  assert.equal(labels.id_at(row), far.id);
  assert.equal(labels.id_at(3), 3);
  labels.set_objects([chair, far]);
  assert.deepEqual(class_texel(labels, far.id), [7, 8, 9, 255]);
  labels.select(far.id);
  assert.equal(object_texel(labels, far.id)[3], kSelected);
  labels.select(0);
  labels.drop(far.id);
  assert.equal(labels.row_of(far.id), row, 'something still shows it');
  labels.drop(far.id);
  assert.equal(labels.row_of(far.id), undefined);
  assert.equal(labels.take(70_000), row);
  assert.deepEqual(class_texel(labels, 70_000), [...kUnknownColor, 255], 'nothing of the old one is left');
});

test('Labels: what comes and goes never runs out of rows', () => {
  const labels = labelled();
  for (let id = 1000; id < 1000 + 3 * kRows; ++id) {
    assert.ok(labels.take(id) > 0);
    labels.drop(id);
  }
});

test('Labels: what is not there yet is faded, and hidden stays hidden', () => {
  const labels = labelled();
  labels.set_faded(new Set([57]));
  assert.equal(class_texel(labels, 57)[3], kFaded);
  assert.equal(labels.is_faded(57), true);
  labels.show_object(57, false);
  assert.equal(class_texel(labels, 57)[3], 0);
  labels.show_object(57, true);
  labels.set_faded(new Set());
  assert.equal(class_texel(labels, 57)[3], 255);
});
