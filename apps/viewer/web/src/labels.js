// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// What the panoptic ids on the surface mean: class, name, colours, shown or not. The surface holds ids only and looks the rest up in
// `texels`, so that a new class, a hidden class or a marked object never needs a vertex to be sent again.

export const kIds = 65536;
export const kUnknownColor = [138, 140, 145];
const kTexel = 4;
const kSecondHalf = kIds * kTexel;
export const kHovered = 128;
export const kSelected = 255;

const kUnknown = { id: 0, name: 'unknown', is_thing: false, color: kUnknownColor };

export class Labels {
  // Two tables of 256 x 256 texels, one above the other, a texel per panoptic id:
  //   red, green, blue of the class,  255 where shown      then      red, green, blue of the object,  mark
  texels = new Uint8Array(2 * kSecondHalf);
  changed = true;  // whoever copies the texels clears it
  first_thing = kIds;
  selected = 0;
  hovered = 0;
  #classes = new Map([[0, kUnknown]]);
  #objects = new Map();
  #hidden_classes = new Set();
  #hidden_objects = new Set();

  reset(scene) {
    this.first_thing = scene.first_thing;
    this.#classes = new Map(scene.classes.map((entry) => [entry.id, entry]));
    this.#classes.set(0, kUnknown);
    this.#objects.clear();
    this.#hidden_classes.clear();
    this.#hidden_objects.clear();
    this.selected = 0;
    this.hovered = 0;
    this.#write_all();
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
    for (let id = 0; id < kIds; ++id) this.#write(id);
  }

  #write(id) {
    const at = id * kTexel;
    const mark = id === 0 ? 0 : id === this.selected ? kSelected : id === this.hovered ? kHovered : 0;
    this.texels.set(this.class_of(id).color, at);
    this.texels[at + 3] = this.is_object_shown(id) ? 255 : 0;
    this.texels.set(this.color_of(id), kSecondHalf + at);
    this.texels[kSecondHalf + at + 3] = mark;
    this.changed = true;
  }
}
