// Births that calculators send each other, in steps along a ring: sorted into a step's messages and read from them.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "comm/message.h"
#include "domains/domains.h"
#include "particles/store.h"
#include "roles/ring.h"

namespace motes::frame {

/// Particles of one group of births on their way, and the calculator that each belongs to.
struct BirthBatch {
  std::uint32_t group;  // its number in the round
  particles::Store store;
  std::vector<std::uint32_t> owners;

  /// Newborn particles of a system with these domains.
  BirthBatch(std::uint32_t number, particles::Store newborn, const domains::Domains& domains);
  /// Nothing yet.
  BirthBatch(std::uint32_t number, const particles::Schema& schema) : group(number), store(schema) {}
};

/// What stays here, and behind it the step's messages in the order of ring.ahead(step). Headers count the particles.
std::vector<comm::Message> split(std::span<const BirthBatch> batches, const roles::Ring& ring, int step);

/// Adds what messages hold; batches[g] is of group g. Returns how many particles came. Throws where there is no such
/// group, or a message ends too early.
std::uint64_t join(std::span<const comm::Message> messages, std::span<BirthBatch> batches);

/// Takes the particles of one group that stand next in a message into their system.
void take(particles::Reader& in, std::uint32_t group, particles::Store& store);

}  // namespace motes::frame
