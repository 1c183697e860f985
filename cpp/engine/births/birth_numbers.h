// Births that calculators send each other in steps along a ring: sorts them into the messages of a step, and reads
// them.
#pragma once

#include <cstdint>
#include <span>
#include <type_traits>
#include <vector>

#include "base/bytes.h"
#include "comm/message.h"
#include "roles/ring.h"

namespace motes::engine {

/// A birth to be sent to its owner: only its number, since the particle is a function of it.
struct Due {
  std::uint32_t number;  // index of the birth in its group
  std::uint32_t owner;   // calculator that owns it
  bool operator==(const Due&) const = default;
};
static_assert(sizeof(Due) == 8 && std::has_unique_object_representations_v<Due>);  // sent as raw bytes

/// Births of one group that are at one calculator between two steps.
struct BirthNumbers {
  std::uint32_t group = 0;  // index of the group in the round
  std::vector<Due> births;
};

/// Splits births into messages of a step: first those that stay here, then one message per ring.ahead(step), in its
/// order. Headers count the births.
std::vector<comm::Message> split(std::span<const BirthNumbers> groups, const roles::Ring& ring, int step);

/// Adds the births in messages to `groups`, which is indexed by group. Returns their number. Throws if a group does not
/// exist or a message is too short.
std::uint64_t join(std::span<const comm::Message> messages, std::span<BirthNumbers> groups);

/// Reads the numbers of one group that come next in a message, and appends them. Throws if one is not below `count`.
void take(base::Reader& in, std::uint32_t group, std::uint64_t count, std::vector<std::uint32_t>& numbers);

}  // namespace motes::engine
