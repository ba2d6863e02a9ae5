// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Seats, places to lie and table tops of affordances.json in the frame of the figures: Detour's axes (x, z, -y), y is up; and which
// of them is meant by a point of the surface.
import rules from './rules.json' with { type: 'json' };

const turned = ([x, y, z]) => [x, z, -y];

export function places_of(affordances) {
  return {
    seats: affordances.seats.map((seat, number) => ({ number, object: seat.object, at: turned(seat.position), facing: turned(seat.facing), height: seat.height_m })),
    beds: affordances.lying_places.map((bed, number) => ({ number, object: bed.object, at: turned(bed.center), axis: turned(bed.axis), height: bed.height_m,
      length: bed.length_m, width: bed.width_m, polygon: bed.polygon.map(turned) })),
    tables: affordances.table_tops.map((top, number) => ({ number, object: top.object, height: top.height_m, polygon: top.polygon.map(turned),
      free: (top.free_rectangles ?? []).map((corners) => corners.map(turned)) })),
  };
}

// From above.
export function is_inside(polygon, [x, , z]) {
  let inside = false;
  for (let i = 0, j = polygon.length - 1; i < polygon.length; j = i++) {
    const [a, b] = [polygon[i], polygon[j]];
    if ((a[2] > z) !== (b[2] > z) && x < ((b[0] - a[0]) * (z - a[2])) / (b[2] - a[2]) + a[0]) inside = !inside;
  }
  return inside;
}

const apart = (a, b) => Math.hypot(a[0] - b[0], a[2] - b[2]);

// The meaning of a click on the surface: {kind: 'seat' | 'bed' | 'table' | 'floor' | 'nothing', place}. `id`: the object there.
export function meant(places, id, at, free = () => true) {
  const beds = places.beds.filter((bed) => bed.object === id);
  const seats = places.seats.filter((seat) => seat.object === id && free(seat)).sort((a, b) => apart(a.at, at) - apart(b.at, at));
  const is_long = beds.length > 0 && seats.length === 0;
  if (is_long) return { kind: 'bed', place: beds[0] };
  if (seats.length > 0) return { kind: 'seat', place: seats[0], bed: beds[0] ?? null };
  const table = places.tables.find((top) => Math.abs(at[1] - top.height) < 0.06 && (top.object === id || is_inside(top.polygon, at)));
  if (table) return { kind: 'table', place: table };
  if (at[1] < 0.12) return { kind: 'floor', place: null };
  return { kind: 'nothing', place: null };
}

// Where one could stand to sit down there: first ahead of the seat, then to its sides; [x, y, z] with y = 0.
export function spots_before(seat) {
  const [fx, , fz] = seat.facing;
  const spots = [];
  for (const distance of rules.spots.distances_m) {
    for (const turn of rules.spots.turns_rad) {
      const [c, s] = [Math.cos(turn), Math.sin(turn)];
      spots.push({ at: [seat.at[0] + distance * (c * fx + s * fz), 0, seat.at[2] + distance * (c * fz - s * fx)], cost: distance + rules.spots.turn_costs_m * Math.abs(turn) });
    }
  }
  return spots.sort((a, b) => a.cost - b.cost);
}

// The edges of a bed on which one sits down first: {edge, out} with `out` away from the bed.
export function edges_of(bed) {
  const [ax, , az] = bed.axis;
  const out = [[az, 0, -ax], [-az, 0, ax], [-ax, 0, -az]];
  return out.map(([x, , z], i) => {
    const half = i < 2 ? bed.width / 2 : bed.length / 2;
    const inward = Math.max(0, half - rules.bed.edge_m);
    return { at: [bed.at[0] + inward * x, bed.height, bed.at[2] + inward * z], facing: [x, 0, z], height: bed.height };
  });
}
