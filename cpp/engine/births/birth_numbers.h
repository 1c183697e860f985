// Births that calculators tell each other of, in steps along a ring: sorted into a step's messages and read from them.
#pragma once

#include <cstdint>
#include <span>
#include <type_traits>
#include <vector>

#include "base/bytes.h"
#include "comm/message.h"
#include "roles/ring.h"

namespace motes::engine {

/// A birth on its way to its owner: only its number travels, since the particle is a function of it.
struct Due {
  std::uint32_t number;  // number of the birth in its group
  std::uint32_t owner;   // the calculator that it belongs to
  bool operator==(const Due&) const = default;
};
static_assert(sizeof(Due) == 8 && std::has_unique_object_representations_v<Due>);  // sent as raw bytes

/// Births of one group that are at one calculator, on their way.
struct BirthNumbers {
  std::uint32_t group = 0;  // number of the group in the round
  std::vector<Due> births;
};

/// Returns the births that stay here, then the step's messages in the order of ring.ahead(step). Headers count the
/// births.
std::vector<comm::Message> split(std::span<const BirthNumbers> groups, const roles::Ring& ring, int step);

/// Adds what messages hold; groups[g] is of group g. Returns how many births came. Throws where there is no such group,
/// or a message ends too early.
std::uint64_t join(std::span<const comm::Message> messages, std::span<BirthNumbers> groups);

/// Adds the numbers of one group that stand next in a message. Throws where one is not below `count`.
void take(base::Reader& in, std::uint32_t group, std::uint64_t count, std::vector<std::uint32_t>& numbers);

}  // namespace motes::engine
