// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Where figures can go: the one seam to Recast and Detour as WebAssembly. Points are [x, y, z] in Detour's axes.
import { Crowd, importNavMesh, init, NavMeshQuery } from 'recast-navigation';
import rules from './rules.json' with { type: 'json' };

const { walk } = rules;
const kAgent = { radius: walk.radius_m, height: walk.height_m, maxAcceleration: walk.acceleration_m_s2, maxSpeed: walk.speed_m_s, collisionQueryRange: walk.looks_m,
  pathOptimizationRange: walk.optimizes_m, separationWeight: walk.separation };
const kMostAgents = rules.most_agents;
export const kStep_s = 1 / rules.steps_per_s;

let ready = null;
export const start_recast = () => (ready ??= init());

const xyz = ([x, y, z]) => ({ x, y, z });
const list = ({ x, y, z }) => [x, y, z];

export class Mesh {
  navMesh;
  query;

  // The bytes of a file of Detour's tiles. Throws if they are none.
  constructor(bytes) {
    const magic = new DataView(bytes.buffer, bytes.byteOffset, Math.min(8, bytes.byteLength));
    if (bytes.byteLength < 8 || magic.getUint32(0, true) !== 0x4d534554) throw new Error('this is no navigation mesh');
    this.navMesh = importNavMesh(bytes).navMesh;
    this.query = new NavMeshQuery(this.navMesh);
  }

  // The nearest place to stand, at most `far` away; null if there is none.
  nearest(at, far = 0.5) {
    const found = this.query.findClosestPoint(xyz(at), { halfExtents: { x: far, y: 1, z: far } });
    if (!found.success || !found.polyRef) return null;
    const point = list(found.point);
    return Math.hypot(point[0] - at[0], point[2] - at[2]) <= far ? point : null;
  }

  // The corners of the shortest way, both ends included; null if there is none.
  way(from, to) {
    const found = this.query.computePath(xyz(from), xyz(to), { halfExtents: { x: 0.3, y: 1, z: 0.3 } });
    if (!found.success || found.path.length === 0) return null;
    const corners = found.path.map(list);
    const end = corners.at(-1);
    return Math.hypot(end[0] - to[0], end[2] - to[2]) < 0.12 ? corners : null;
  }

  random() {
    const found = this.query.findRandomPoint();
    return found?.success ? list(found.randomPoint) : null;
  }

  destroy() {
    this.query.destroy();
    this.navMesh.destroy();
  }
}

// The floor with those who walk on it and avoid each other.
export class Floor extends Mesh {
  #crowd;

  constructor(bytes) {
    super(bytes);
    this.#crowd = new Crowd(this.navMesh, { maxAgents: kMostAgents, maxAgentRadius: kAgent.radius });
  }

  // Somebody who stands there, or moves with that velocity; null if there are too many already.
  enter(at, speed = kAgent.maxSpeed, velocity = [0, 0, 0]) {
    if (this.#crowd.getAgents().length >= kMostAgents) return null;
    const agent = this.#crowd.addAgent(xyz(at), { ...kAgent, maxSpeed: speed });
    velocity.forEach((value, i) => agent.raw.set_vel(i, value));
    return {
      place: () => list(agent.position()), velocity: () => list(agent.velocity()),
      go: (to) => agent.requestMoveTarget(xyz(to)), stop: () => agent.resetMoveTarget(), leave: () => this.#crowd.removeAgent(agent),
      is_clear: (at) => this.is_clear(at, agent),
    };
  }

  // Whether nobody else is there.
  is_clear([x, , z], own = null) {
    return this.#crowd.getAgents().every((agent) => {
      if (agent.agentIndex === own?.agentIndex) return true;
      const at = agent.position();
      return Math.hypot(at.x - x, at.z - z) > 2 * kAgent.radius;
    });
  }

  step() {
    this.#crowd.update(kStep_s);
  }

  destroy() {
    this.#crowd.destroy();
    super.destroy();
  }
}
