// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The meaning of the panoptic ids on the surface: class, name, colours, shown or not. The surface holds rows of `texels` only
// and looks the rest up there, so that a new class, a hidden class or a marked object never needs a vertex to be sent again.
// Ids have 32 bits and are never given twice; a row is given anew when the object is not on the surface any more.

export const kRows = 65536;  // more than a map has objects at a time
export const kUnknownColor = [138, 140, 145];
const kTexel = 4;
const kSecondHalf = kRows * kTexel;
export const kHovered = 128;
export const kSelected = 255;
export const kFaded = 128;  // in place of 255 where shown

const kUnknown = { id: 0, name: 'unknown', is_thing: false, color: kUnknownColor };

export class Labels {
  // Two tables of 256 x 256 texels, one above the other, a texel per row:
  //   red, green, blue of the class,  255 where shown, kFaded where not there yet      then      red, green, blue of the object,  mark
  texels = new Uint8Array(2 * kSecondHalf);
  changed = true;  // whoever copies the texels clears it
  first_thing = kRows;
  selected = 0;
  hovered = 0;
  #classes = new Map([[0, kUnknown]]);
  #objects = new Map();
  #hidden_classes = new Set();
  #hidden_objects = new Set();
  #faded = new Set();  // objects that are not there yet, at a time in the past
  #taken = new Map();  // objects on the surface: id -> {row, uses}
  #id_of_row = [];     // their ids
  #free_rows = [];
  #next_row = 0;       // rows from here on were never taken

  reset(scene) {
    this.first_thing = scene.first_thing;
    this.#taken.clear();
    this.#id_of_row = [];
    this.#free_rows = [];
    this.#next_row = scene.first_thing;
    this.#classes = new Map(scene.classes.map((entry) => [entry.id, entry]));
    this.#classes.set(0, kUnknown);
    this.#objects.clear();
    this.#hidden_classes.clear();
    this.#hidden_objects.clear();
    this.#faded = new Set();
    this.selected = 0;
    this.hovered = 0;
    this.#write_all();
  }

  // The row of what is on the surface, to be dropped as often as it was taken. Classes have the row of their number. Should there be
  // no row left, the object looks unknown.
  take(id) {
    if (id < this.first_thing) return id;
    const taken = this.#taken.get(id);
    if (taken) return ++taken.uses, taken.row;
    const row = this.#free_rows.pop() ?? (this.#next_row < kRows ? this.#next_row++ : 0);
    this.#taken.set(id, { row, uses: 1 });
    this.#id_of_row[row] = id;
    this.#write(id);
    return row;
  }

  drop(id) {
    const taken = this.#taken.get(id);
    if (!taken || --taken.uses > 0) return;
    this.#taken.delete(id);
    if (taken.row > 0) this.#free_rows.push(taken.row);
  }

  // undefined for an object that is not on the surface.
  row_of(id) {
    return id < this.first_thing ? id : this.#taken.get(id)?.row;
  }

  id_at(row) {
    return row < this.first_thing ? row : (this.#id_of_row[row] ?? 0);
  }

  get classes() {
    return [...this.#classes.values()];
  }

  get objects() {
    return [...this.#objects.values()];
  }

  // Only what differs from before is written, and who listens is told only then.
  set_objects(objects) {
    const before = this.#objects;
    this.#objects = new Map(objects.map((object) => [object.id, object]));
    for (const id of new Set([...before.keys(), ...this.#objects.keys()])) {
      const old = before.get(id);
      const now = this.#objects.get(id);
      if (old?.class_id !== now?.class_id || `${old?.color}` !== `${now?.color}`) this.#write(id);
    }
  }

  object(id) {
    return this.#objects.get(id);
  }

  class_of(id) {
    const class_id = id < this.first_thing ? id : (this.#objects.get(id)?.class_id ?? 0);
    return this.#classes.get(class_id) ?? this.#classes.get(0);
  }

  class_named(class_id) {
    return this.#classes.get(class_id) ?? this.#classes.get(0);
  }

  name_of(id) {
    return this.#objects.get(id)?.name ?? (id < this.first_thing ? this.class_of(id).name : `unknown_${id}`);
  }

  color_of(id) {
    if (id === 0) return kUnknownColor;
    return this.#objects.get(id)?.color ?? (id < this.first_thing ? this.class_of(id).color : kUnknownColor);
  }

  is_class_shown(class_id) {
    return !this.#hidden_classes.has(class_id);
  }

  is_object_shown(id) {
    return !this.#hidden_objects.has(id) && this.is_class_shown(this.class_of(id).id);
  }

  show_class(class_id, shown) {
    this.show_classes([class_id], shown);
  }

  show_classes(class_ids, shown) {
    for (const id of class_ids) shown ? this.#hidden_classes.delete(id) : this.#hidden_classes.add(id);
    this.#write_all();
  }

  show_object(id, shown) {
    shown ? this.#hidden_objects.delete(id) : this.#hidden_objects.add(id);
    this.#write(id);
  }

  is_faded(id) {
    return this.#faded.has(id);
  }

  set_faded(ids) {
    const before = this.#faded;
    this.#faded = ids;
    for (const id of new Set([...before, ...ids])) if (before.has(id) !== ids.has(id)) this.#write(id);
  }

  select(id) {
    const before = this.selected;
    this.selected = id;
    this.#write(before);
    this.#write(id);
  }

  hover(id) {
    if (id === this.hovered) return false;
    const before = this.hovered;
    this.hovered = id;
    this.#write(before);
    this.#write(id);
    return true;
  }

  #write_all() {
    for (let id = 0; id < this.first_thing; ++id) this.#write(id);
    for (const id of this.#taken.keys()) this.#write(id);
  }

  #write(id) {
    const row = this.row_of(id);
    if (row === undefined || (row === 0 && id !== 0)) return;
    const at = row * kTexel;
    const mark = id === 0 ? 0 : id === this.selected ? kSelected : id === this.hovered ? kHovered : 0;
    this.texels.set(this.class_of(id).color, at);
    this.texels[at + 3] = !this.is_object_shown(id) ? 0 : this.#faded.has(id) ? kFaded : 255;
    this.texels.set(this.color_of(id), kSecondHalf + at);
    this.texels[kSecondHalf + at + 3] = mark;
    this.changed = true;
  }
}
