#include "recording/spawn.h"

#include <algorithm>
#include <cmath>

#include "actions/action.h"
#include "base/invalid_argument.h"
#include "simd/float_mode.h"

namespace motes::recording {
namespace {

using particles::Store;

}  // namespace

void check(const Spawn& spawn, const particles::Schema& parents, const particles::Schema& children) {
  if (spawn.count < 1 || spawn.count > 1000000) {
    throw base::InvalidArgument("count", "be 1..1000000", std::to_string(spawn.count));
  }
  if (!(std::fabs(spawn.inherit_velocity) <= 1e6)) {
    throw base::InvalidArgument("inherit_velocity", "be within 1e6", std::to_string(spawn.inherit_velocity));
  }
  check(spawn.state, children, nullptr);
  actions::check_condition(spawn.where, spawn.shapes, parents);
}

Store make(const Spawn& rule, const std::vector<Child>& children, const particles::Schema& schema, particles::Key key,
           bool keeps_copies) {
  const simd::FloatMode mode;
  Emit emit;
  emit.count = children.size();
  emit.state = rule.state;
  std::vector<float>& positions = emit.columns.emplace_back(Emitted{particles::position, {}}).values;
  std::vector<std::uint64_t> ids;
  for (const Child& child : children) {
    ids.push_back(child.id);
    positions.insert(positions.end(), child.event->position, child.event->position + 3);
  }
  Store newborn = make(emit, schema, key, ids, 0, keeps_copies);
  const auto part = static_cast<float>(rule.inherit_velocity);
  for (int c = 0; part != 0 && c < 3 && newborn.size() > 0; ++c) {
    float* v = newborn.writable_plane(particles::velocity, c);
    for (std::size_t i = 0; i < newborn.size(); ++i) v[i] += part * children[i].event->velocity[c];
  }
  const bool given = std::any_of(rule.state.begin(), rule.state.end(),
                                 [](const Given& g) { return g.attribute == particles::velocity_b; });
  if (keeps_copies && part != 0 && !given) newborn.copy_attribute(particles::velocity, particles::velocity_b);
  return newborn;
}

}  // namespace motes::recording
