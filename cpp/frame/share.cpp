// create, another way: each calculator makes a part of the births, by their numbers, and hands them to their owners in
// two steps along a grid. Particles depend on their numbers alone, so they are those that the manager would make.
#include <algorithm>

#include "frame/engine.h"
#include "frame/work.h"

namespace motes::frame {

using comm::Message;
using comm::Phase;
using particles::Reader;

namespace {

void put(int owner, const Part& part, Message& message) {
  message.bytes().put(static_cast<std::uint32_t>(owner));
  message.bytes().put(part.count);
  message.bytes().put(static_cast<std::uint64_t>(part.bytes.size()));
  message.bytes().put_raw(part.bytes.data(), part.bytes.size());
}

// Whose it is, and the part.
std::pair<int, Part> get_part(Reader& in) {
  const auto owner = static_cast<int>(in.get<std::uint32_t>());
  Part part;
  part.count = in.get<std::uint64_t>();
  const auto bytes = in.take(in.get<std::uint64_t>());
  part.bytes.put_raw(bytes.data(), bytes.size());
  return {owner, std::move(part)};
}

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
  const roles::Grid grid(static_cast<int>(cast_.calculators.size()));
  scatter(round, grid, make_share(round));
  std::map<int, Message> sorted = sort_shares(round, grid);
  for (const int to : grid.column(calculator())) {
    Message& message = sorted[to];
    std::uint64_t count = 0;
    for (Reader in = message.reader(); !in.done();) count += get_part(in).second.count;
    comm_->post(cast_.calculators[static_cast<std::size_t>(to)], Phase::newborn, stamp(round), std::move(message),
                count, failure_.failed());
  }
  for (const int from : grid.column(calculator())) {
    const Message message =
        comm_->expect(cast_.calculators[static_cast<std::size_t>(from)], Phase::newborn, stamp(round));
    for (Reader in = message.reader(); !in.done();) {
      newborn.shares.push_back(get_part(in).second);
      newborn.readers.emplace_back(newborn.shares.back().bytes.view());
    }
    newborn.count += message.header().count;
  }
}

Engine::Parts Engine::make_share(const Round& round) {
  Parts parts;
  work("create", [&] {
    const std::size_t calculators = cast_.calculators.size();
    const auto self = static_cast<std::size_t>(calculator());
    std::uint32_t number = 0;
    for (std::size_t i = round.first; i < round.last; ++i) {
      for (const BirthGroup& group : groups_[i]) {
        const std::uint64_t first = share(group.count, calculators, self);
        const std::uint64_t last = share(group.count, calculators, self + 1);
        make_births(*systems_[i], group, first, last,
                    [&](const particles::Store& piece) { pack_share(*systems_[i], piece, number, parts); });
        charge(options_.costs.birth * static_cast<double>(last - first));
        ++number;
      }
    }
  });
  if (failure_.failed()) parts.clear();
  return parts;
}

void Engine::pack_share(const System& system, const particles::Store& piece, std::uint32_t group, Parts& parts) {
  std::map<int, std::vector<std::uint32_t>> owned;
  const float* x = piece.plane(particles::position, system.definition.axis);
  for (std::size_t p = 0; p < piece.size(); ++p) {
    owned[system.domains.owner_of(x[p])].push_back(static_cast<std::uint32_t>(p));
  }
  for (const auto& [owner, indices] : owned) {
    Part& part = parts[owner];
    part.bytes.put(group);
    piece.pack(indices, part.bytes);
    part.count += indices.size();
  }
}

// The first step: what is for a column's calculators goes to one of them.
void Engine::scatter(const Round& round, const roles::Grid& grid, const Parts& parts) {
  const std::vector<int> along = grid.along(calculator());
  std::vector<Message> messages(along.size());
  std::vector<std::uint64_t> counts(along.size(), 0);
  for (const auto& [owner, part] : parts) {
    const auto column = static_cast<std::size_t>(owner % grid.columns());
    put(owner, part, messages[column]);
    counts[column] += part.count;
  }
  for (std::size_t column = 0; column < along.size(); ++column) {
    comm_->post(cast_.calculators[static_cast<std::size_t>(along[column])], Phase::births, stamp(round),
                std::move(messages[column]), counts[column], failure_.failed());
  }
}

// Between the steps: what came for this column, by owner.
std::map<int, Message> Engine::sort_shares(const Round& round, const roles::Grid& grid) {
  std::map<int, Message> sorted;
  for (const int from : grid.from_along(calculator())) {
    const Message message =
        comm_->expect(cast_.calculators[static_cast<std::size_t>(from)], Phase::births, stamp(round));
    for (Reader in = message.reader(); !in.done();) {
      const auto [owner, part] = get_part(in);
      put(owner, part, sorted[owner]);
    }
  }
  return sorted;
}

// Its particles of the next group.
void Engine::take_shares(System& system, Newborn& newborn) {
  for (Reader& in : newborn.readers) {
    while (!in.done()) {
      Reader ahead = in;
      if (ahead.get<std::uint32_t>() != newborn.group) break;
      in = ahead;
      system.store->unpack(in);
    }
  }
  ++newborn.group;
}

}  // namespace motes::frame
