#include "lab/bench/bench_births.h"

#include <algorithm>
#include <array>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "comm/clock.h"
#include "domains/divide.h"
#include "engine/births/birth_numbers.h"
#include "engine/state/places.h"
#include "engine/state/population.h"
#include "lab/bench/bench_scene.h"
#include "program/program.h"
#include "recording/births.h"
#include "simd/float_mode.h"

namespace motes::bench {
namespace {

using namespace engine;

using particles::Store;

constexpr float kMetres = 4;  // width of a domain
constexpr std::size_t kOld = 200000;  // room for particles besides the newborn
constexpr float kStep = 1.0f / 24;  // seconds

recording::Source snow(float width) {
  recording::Source source;
  source.shape = {shapes::Kind::rectangle, {-width / 2, 12, -4, width, 0, 0, 0, 0, 8}};
  const actions::distributions::InShape velocity{{shapes::Kind::box, {-0.4, -1.4, -0.3, 0.4, -1.2, 0.3}}};
  source.state = {{particles::velocity, velocity}, {particles::age, {}}};
  return source;
}

// Appends the number and the owner of each newborn particle.
void add_owners(const Store& newborn, const domains::Domains& domains, std::uint64_t first, std::vector<Due>& births) {
  std::vector<std::uint32_t> owners(newborn.size());
  domains.owners_of(places_of(newborn), owners.data());
  births.reserve(owners.size());
  for (std::size_t p = 0; p < owners.size(); ++p) {
    births.push_back({static_cast<std::uint32_t>(newborn.ids()[p] - first), owners[p]});
  }
}

// Creates the births that messages list, as their owner does, and appends them to its system.
void make_own(std::span<const comm::Message> messages, const recording::Birth& birth, particles::Key key,
              std::uint64_t first, std::uint64_t count, Store& system) {
  std::vector<std::uint32_t> numbers;
  for (const comm::Message& message : messages) {
    base::Reader in = message.reader();
    take(in, 0, count, numbers);
  }
  std::vector<std::uint64_t> ids(numbers.size());
  std::transform(numbers.begin(), numbers.end(), ids.begin(), [&](std::uint32_t number) { return first + number; });
  const Store made = recording::make(birth, system.schema(), key, ids, kStep, false, first);
  system.append(made);
}

}  // namespace

BirthBench birth_bench(int calculators, int births, int repeats) {
  if (calculators < 1 || births < 1 || repeats < 1) {
    throw std::invalid_argument("calculators, births and repeats must be 1 or more");
  }
  const simd::FloatMode mode;
  const particles::Schema schema;
  const float width = kMetres * static_cast<float>(calculators);
  const recording::Birth birth = snow(width);
  const domains::Domains domains = domains::equal_slices(-width / 2, width / 2, calculators);
  const roles::Ring ring(calculators, calculators / 2);
  const auto count = static_cast<std::uint64_t>(births);
  const program::Program list(paper_list("snow"));
  program::ListResult outcome;
  std::array<std::vector<double>, 6> seconds;
  Store system(schema);
  for (int i = 0; i < repeats; ++i) {
    const particles::Key key = particles::system_key(1, 0);
    const std::uint64_t first = static_cast<std::uint64_t>(i) * count;
    double start = comm::cpu_seconds();
    const auto lap = [&](std::size_t what) {
      const double now = comm::cpu_seconds();
      seconds[what].push_back(now - start);
      start = now;
    };
    const Store newborn = recording::make(birth, schema, key, first, count, kStep, false, 0);
    lap(0);
    std::vector<BirthNumbers> groups(1);
    add_owners(newborn, domains, first, groups[0].births);
    lap(1);
    std::vector<comm::Message> messages = split(groups, ring, 0);
    lap(2);
    std::vector<BirthNumbers> between(1);
    join(messages, between);
    messages = split(between, ring, std::max(ring.steps() - 1, 0));
    lap(3);
    if (system.size() > kOld) system = Store(schema);
    system.reserve(kOld + count);
    const std::size_t begin = system.size();
    start = comm::cpu_seconds();
    make_own(messages, birth, key, first, count, system);
    lap(4);
    list.run(system, begin, 0, {static_cast<std::uint64_t>(i), 1, kStep, 0, 1}, key, {}, outcome);
    lap(5);
    outcome.clear();
  }
  const auto each = [&](std::size_t what) { return 1e9 * median(seconds[what]) / births; };
  return {each(0), each(1), each(2), each(3), each(4), each(5)};
}

}  // namespace motes::bench
