// Numbers of births in the messages of a step: each reaches its owner once, and invalid ones are refused.
#include <algorithm>
#include <cstdint>
#include <numeric>
#include <stdexcept>
#include <utility>
#include <vector>

#include "engine/births/birth_numbers.h"
#include "engine/births/share.h"
#include "roles/ring.h"
#include "support/check.h"
#include "support/isas.h"

namespace motes::test_birth_numbers {
using comm::Message;
using engine::BirthNumbers;
using engine::Due;

namespace {

constexpr std::uint32_t kGroups = 3;

// Returns each calculator's part of three groups, one of them empty, with random owners.
std::vector<std::vector<BirthNumbers>> shares(int calculators, std::uint64_t seed) {
  test::Dice dice(seed);
  std::uint32_t next[kGroups] = {};
  std::vector<std::vector<BirthNumbers>> all(static_cast<std::size_t>(calculators));
  for (std::vector<BirthNumbers>& share : all) {
    for (std::uint32_t g = 0; g < kGroups; ++g) {
      share.push_back({g, {}});
      for (std::size_t left = g == 1 ? 0 : dice.below(30); left > 0; --left) {
        const auto owner = static_cast<std::uint32_t>(dice.below(static_cast<std::size_t>(calculators)));
        share.back().births.push_back({next[g]++, owner});
      }
    }
  }
  return all;
}

// Returns what each calculator has after all steps along the ring, where messages arrive at once.
std::vector<std::vector<Message>> travel(std::vector<std::vector<BirthNumbers>> all) {
  const int calculators = static_cast<int>(all.size());
  std::vector<std::vector<Message>> here(all.size());
  for (int step = 0; step < roles::Ring(calculators, 0).steps(); ++step) {
    std::vector<std::vector<Message>> arrived(all.size());
    for (int c = 0; c < calculators; ++c) {
      const auto self = static_cast<std::size_t>(c);
      const roles::Ring ring(calculators, c);
      std::vector<BirthNumbers> between{{0, {}}, {1, {}}, {2, {}}};
      if (step > 0) join(here[self], between);
      std::vector<Message> messages = split(step > 0 ? between : all[self], ring, step);
      const std::vector<int> ahead = ring.ahead(step);
      CHECK(messages.size() == ahead.size() + 1);
      arrived[self].push_back(std::move(messages[0]));
      for (std::size_t m = 0; m < ahead.size(); ++m) {
        arrived[static_cast<std::size_t>(ahead[m])].push_back(std::move(messages[m + 1]));
      }
    }
    here = std::move(arrived);
  }
  return here;
}

std::vector<std::uint32_t> due_to(const std::vector<std::vector<BirthNumbers>>& all, std::uint32_t group,
                                  std::uint32_t owner) {
  std::vector<std::uint32_t> due;
  for (const std::vector<BirthNumbers>& share : all) {
    for (const Due& birth : share[group].births) {
      if (birth.owner == owner) due.push_back(birth.number);
    }
  }
  return due;
}

Message message_of(std::uint32_t group, std::uint32_t count, const std::vector<Due>& births) {
  Message message;
  message.bytes().put(group);
  message.bytes().put(count);
  message.bytes().put_raw(births.data(), births.size() * sizeof(Due));
  message.set_header({});
  return message;
}

}  // namespace

TEST(numbers_of_births_reach_their_owners_once_group_by_group) {
  for (const int calculators : {2, 3, 5, 16, 17, 40, 257, 300}) {
    const auto all = shares(calculators, static_cast<std::uint64_t>(calculators));
    const std::vector<std::vector<Message>> here = travel(all);
    for (std::uint32_t c = 0; c < here.size(); ++c) {
      std::vector<base::Reader> readers;
      std::uint64_t counted = 0;
      for (const Message& message : here[c]) {
        readers.push_back(message.reader());
        counted += message.header().count;
      }
      std::size_t taken = 0;
      for (std::uint32_t g = 0; g < kGroups; ++g) {
        std::vector<std::uint32_t> numbers;
        for (base::Reader& in : readers) engine::take(in, g, UINT32_MAX, numbers);
        std::sort(numbers.begin(), numbers.end());
        CHECK(numbers == due_to(all, g, c));
        taken += numbers.size();
      }
      CHECK(counted == taken);
      CHECK(std::all_of(readers.begin(), readers.end(), [](const auto& in) { return in.done(); }));
    }
  }
}

TEST(who_creates_births_follows_from_how_many_there_are) {
  using engine::Births;
  CHECK(engine::quicker_births(1'000'000'000, 1) == Births::manager);
  std::uint64_t border = 0;
  for (const std::size_t calculators : {std::size_t{16}, std::size_t{17}, std::size_t{300}, std::size_t{5000}}) {
    CHECK(engine::quicker_births(1000, calculators) == Births::manager);
    CHECK(engine::quicker_births(20'000, calculators) == Births::calculators);
    const std::uint64_t before = border;  // with more steps there is more to wait for
    for (border = 1000; engine::quicker_births(border, calculators) == Births::manager;) ++border;
    CHECK(border > before);
  }
}

TEST(numbers_of_births_that_cannot_be_are_refused) {
  std::vector<BirthNumbers> one{{0, {}}};
  const Message stranger = message_of(1, 1, {{0, 0}});
  CHECK_THROWS(join({&stranger, 1}, one), std::runtime_error);
  const Message cut_off = message_of(0, 2, {{0, 0}});
  CHECK_THROWS(join({&cut_off, 1}, one), std::runtime_error);
  std::vector<std::uint32_t> numbers;
  const Message beyond = message_of(0, 1, {{7, 0}});
  base::Reader in = beyond.reader();
  CHECK_THROWS(engine::take(in, 0, 7, numbers), std::runtime_error);
  in = beyond.reader();
  numbers.clear();
  engine::take(in, 0, 8, numbers);
  CHECK(numbers == std::vector<std::uint32_t>{7});
}

}  // namespace motes::test_birth_numbers
