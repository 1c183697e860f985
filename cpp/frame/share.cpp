// create, another way: each calculator makes a part of the births, by their numbers, and hands them to their owners in
// a few steps along a ring. Particles depend on their numbers alone, so they are those that the manager would make.
#include <algorithm>

#include "frame/engine.h"
#include "frame/flock.h"
#include "frame/work.h"

namespace motes::frame {

using comm::Message;
using comm::Phase;

namespace {

// The first number of calculator c's part of so many births.
std::uint64_t share(std::uint64_t count, std::size_t calculators, std::size_t c) {
  return count / calculators * c + std::min<std::uint64_t>(c, count % calculators);
}

}  // namespace

// Manager: whether calculators make this round's births. All of them send and receive then, also what is empty: nobody
// needs to be told who will.
bool Engine::shares_births(const Round& round) const {
  if (options_.births != Births::calculators || !in_frame() || cast_.calculators.size() < 2) return false;
  return std::any_of(groups_.begin() + static_cast<std::ptrdiff_t>(round.first),
                     groups_.begin() + static_cast<std::ptrdiff_t>(round.last),
                     [](const std::vector<BirthGroup>& groups) { return !groups.empty(); });
}

// A calculator that fails takes part with empty messages.
void Engine::share_births(const Round& round, Newborn& newborn) {
  const roles::Ring ring(static_cast<int>(cast_.calculators.size()), calculator());
  for (int step = 0; step < ring.steps(); ++step) {
    for (const int from : ring.behind(step)) {
      comm_->await(cast_.calculators[static_cast<std::size_t>(from)], Phase::births);
    }
  }
  for (int step = 0; step < ring.steps(); ++step) {
    std::vector<Message> messages(1 + ring.ahead(step).size());
    work("create", [&] {
      const std::vector<Flock> flocks = step == 0 ? make_share(round) : between_steps(round, newborn.shares);
      messages = frame::split(flocks, ring, step);
    });
    newborn.shares = pass_on(round, ring, step, std::move(messages));
  }
  for (const Message& message : newborn.shares) {
    newborn.readers.push_back(message.reader());
    newborn.count += message.header().count;
  }
}

std::vector<Flock> Engine::make_share(const Round& round) const {
  std::vector<Flock> flocks;
  const std::size_t calculators = cast_.calculators.size();
  const auto self = static_cast<std::size_t>(calculator());
  std::uint32_t number = 0;
  for (std::size_t i = round.first; i < round.last; ++i) {
    const System& system = *systems_[i];
    for (const BirthGroup& group : groups_[i]) {
      const std::uint64_t first = share(group.count, calculators, self);
      const std::uint64_t last = share(group.count, calculators, self + 1);
      make_births(system, group, first, last, [&](particles::Store&& piece) {
        flocks.emplace_back(number, std::move(piece), system.domains, system.definition.axis);
      });
      charge(options_.costs.birth * static_cast<double>(last - first));
      ++number;
    }
  }
  return flocks;
}

// All that is here between two steps, a flock a group.
std::vector<Flock> Engine::between_steps(const Round& round, const std::vector<Message>& messages) const {
  std::vector<Flock> flocks;
  for (std::size_t i = round.first; i < round.last; ++i) {
    for (std::size_t g = 0; g < groups_[i].size(); ++g) {
      flocks.emplace_back(static_cast<std::uint32_t>(flocks.size()), systems_[i]->schema);
    }
  }
  charge(options_.costs.forward * static_cast<double>(join(messages, flocks)));
  return flocks;
}

// Sends the step's messages; returns those that came, and what stays.
std::vector<Message> Engine::pass_on(const Round& round, const roles::Ring& ring, int step,
                                     std::vector<Message> messages) {
  const auto rank_of = [&](int c) { return cast_.calculators[static_cast<std::size_t>(c)]; };
  const std::vector<int> ahead = ring.ahead(step);
  for (std::size_t m = 0; m < ahead.size(); ++m) {
    const std::uint64_t count = messages[m + 1].header().count;
    comm_->post(rank_of(ahead[m]), Phase::births, stamp(round), std::move(messages[m + 1]), count, failure_.failed());
  }
  messages.resize(1);
  for (const int from : ring.behind(step)) {
    messages.push_back(comm_->expect(rank_of(from), Phase::births, stamp(round)));
  }
  return messages;
}

// Its particles of the next group.
void Engine::take_shares(System& system, Newborn& newborn) {
  for (particles::Reader& in : newborn.readers) take(in, newborn.group, *system.store);
  ++newborn.group;
}

}  // namespace motes::frame
