// field: an acceleration or an air velocity, interpolated trilinearly between values at the nodes of a regular grid.
#pragma once

#include "actions/lanes.h"

namespace motes::MOTES_ISA {

/// The position of points between the nodes along one axis.
struct NodeAxis {
  Ints node;   // the lower one
  Floats part;
  Mask inside;
};

MOTES_INLINE NodeAxis node_axis(Floats x, float low, float high, int nodes) {
  const Mask inside = (x >= low) & (x <= high);
  const auto cells = static_cast<float>(nodes - 1);
  const Floats at = min(only(inside, (x - low) / (high - low) * cells), all(cells));
  const Ints node = min_ints(to_ints(at), all_ints(nodes > 1 ? nodes - 2 : 0));
  return {node, at - to_floats(node), inside};
}

/// Returns the values at one node per lane.
MOTES_INLINE Floats3 look_up(const float* values, Ints entry) {
  Floats3 found{};
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    const float* v = values + 3 * static_cast<std::ptrdiff_t>(entry[lane]);
    set_lane(found, lane, {v[0], v[1], v[2]});
  }
  return found;
}

MOTES_INLINE Floats3 between(Floats3 a, Floats3 b, Floats part) { return a + (b - a) * part; }

MOTES_INLINE Floats3 trilinear(const actions::TableView& table, const NodeAxis& x, const NodeAxis& y,
                               const NodeAxis& z) {
  const int ny = table.size[1], nz = table.size[2];
  const Ints first = (x.node * ny + y.node) * nz + z.node;
  const int far_x = table.size[0] > 1 ? ny * nz : 0, far_y = ny > 1 ? nz : 0, far_z = nz > 1 ? 1 : 0;
  const auto along_z = [&](Ints at) __attribute__((always_inline)) {
    return between(look_up(table.entries, at), look_up(table.entries, at + far_z), z.part);
  };
  const auto along_y = [&](Ints at)
                           __attribute__((always_inline)) { return between(along_z(at), along_z(at + far_y), y.part); };
  return between(along_y(first), along_y(first + far_x), x.part);
}

inline void field(const actions::Parameters& p, const actions::Block& b, const actions::Step& s) {
  const auto n = numbers_of<numbers::field>(p);
  const actions::TableView& table = *p.bound.table;
  const bool drags = n.drag >= 0;
  const Floats part = drags ? part_gone(all(n.drag * s.dt)) : all(s.dt);
  for (std::size_t i = 0; i < b.count; i += kLanes) {
    const Floats3 at = load3(b, kPositionAt, i), v = load3(b, kVelocityAt, i);
    const NodeAxis x = node_axis(at.x, n.low[0], n.high[0], table.size[0]);
    const NodeAxis y = node_axis(at.y, n.low[1], n.high[1], table.size[1]);
    const NodeAxis z = node_axis(at.z, n.low[2], n.high[2], table.size[2]);
    const Mask inside = x.inside & y.inside & z.inside;
    if (!any(inside)) continue;
    const Floats3 flow = trilinear(table, x, y, z) * n.strength;
    const Floats3 change = (drags ? flow - v : flow) * part;
    store3(b, kVelocityAt, i, select(inside, v + change, v));
  }
}

}  // namespace motes::MOTES_ISA
