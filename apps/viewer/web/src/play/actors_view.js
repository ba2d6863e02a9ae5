// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Draws a crew and the things: one body each, made when it comes and freed when it goes.
import { AmbientLight, DirectionalLight, Group, HemisphereLight, Mesh, MeshBasicMaterial, RingGeometry } from 'three';
import { Body } from './body.js';
import { kFiguresLayer } from './camera_view.js';
import { InsectBody } from './insect_body.js';
import { kOutfits } from './shape.js';
import { kThings } from './things.js';

export class ActorsView {
  group = new Group();
  joints = new Map();  // by person, of the newest picture
  #bodies = new Map();
  #ring;
  #marker;

  constructor() {
    this.group.add(new HemisphereLight('#ffffff', '#8d8478', 1.9), new AmbientLight('#ffffff', 0.35));
    const sun = new DirectionalLight('#fff4e2', 1.5);
    sun.position.set(1.5, 4, 2.5);
    this.group.add(sun);
    const ring = (inner, outer, color) => {
      const mesh = new Mesh(new RingGeometry(inner, outer, 40).rotateX(-Math.PI / 2), new MeshBasicMaterial({ color, transparent: true, opacity: 0.85, depthWrite: false, polygonOffset: true, polygonOffsetFactor: -8, polygonOffsetUnits: -8 }));
      mesh.visible = false;
      this.group.add(mesh);
      return mesh;
    };
    this.#ring = ring(0.25, 0.275, '#1273d4');
    this.#marker = ring(0.06, 0.09, '#1273d4');
    this.#on_layer(this.group);
  }

  set color(color) {
    this.#ring.material.color.set(color);
    this.#marker.material.color.set(color);
  }

  #on_layer(root) {
    root.traverse((part) => part.layers.set(kFiguresLayer));
  }

  #body(key, make, parent = this.group) {
    let body = this.#bodies.get(key);
    if (!body) {
      body = make();
      this.#on_layer(body.group);
      parent.add(body.group);
      this.#bodies.set(key, body);
    }
    return body;
  }

  // Draws a crew, the person who is chosen, and things: [{key, kind, place, turn}].
  update(crew, chosen, things, marks) {
    const seen = new Set();
    for (const person of crew.people) {
      seen.add(person);
      const body = this.#body(person, () => new Body(person.shape, kOutfits[person.number % kOutfits.length]));
      const { actor } = person;
      this.joints.set(person, body.hold(actor.pose, actor.position, actor.heading, actor.place[1]));
      body.shadow.visible = !['sitting', 'lying', 'lying down', 'getting up'].includes(actor.state);
    }
    crew.insects.forEach((item, i) => {
      seen.add(item);
      this.#body(item, () => {
        const body = new InsectBody(i);
        const frame = new Group();
        frame.matrixAutoUpdate = false;
        frame.add(body.group);
        const hold = (insect) => {
          frame.matrix.copy(item.wall.to_figures);
          body.hold(insect, item.lift_m ?? 0);
        };
        return { group: frame, hold, dispose: () => body.dispose() };
      }).hold(item.insect);
    });
    for (const { key, kind, place, turn } of things) {
      seen.add(key);
      const body = this.#body(key, () => ({ group: kThings[kind].make(), dispose() { this.group.traverse((part) => part.geometry?.dispose()); } }));
      body.group.userData.thing = key;
      body.group.position.set(...place);
      body.group.quaternion.set(...turn);
    }
    this.#forget_others(seen);
    this.#show_marks(chosen, marks);
  }

  #forget_others(seen) {
    for (const [key, body] of this.#bodies) {
      if (seen.has(key)) continue;
      this.group.remove(body.group);
      body.dispose();
      this.#bodies.delete(key);
      this.joints.delete(key);
    }
  }

  #show_marks(chosen, marks) {
    const goal = chosen?.actor.goal;
    this.#ring.visible = marks && Boolean(chosen) && !chosen.actor.is_down;
    this.#marker.visible = marks && Boolean(goal) && chosen.actor.state === 'walking';
    if (this.#ring.visible) this.#ring.position.set(chosen.actor.place[0], chosen.actor.place[1] + 0.015, chosen.actor.place[2]);
    if (this.#marker.visible) this.#marker.position.set(goal.spot[0], goal.spot[1] + 0.015, goal.spot[2]);
  }

  // The nearest person or thing that a ray meets: {person | thing, distance}; null if there is none.
  hit(caster) {
    let best = null;
    for (const [key, body] of this.#bodies) {
      const [found] = caster.intersectObject(body.group, true);
      if (found && (best === null || found.distance < best.distance)) best = { key, distance: found.distance };
    }
    return best;
  }
}
