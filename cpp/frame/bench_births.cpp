#include "frame/bench_births.h"

#include <algorithm>
#include <array>
#include <stdexcept>
#include <string>
#include <vector>

#include "comm/clock.h"
#include "domains/divide.h"
#include "frame/birth_batch.h"
#include "recording/bench_scene.h"
#include "recording/births.h"
#include "simd/float_mode.h"

namespace motes::frame {
namespace {

using particles::Store;

constexpr float kMetres = 4;       // width of a domain
constexpr std::size_t kOld = 200000;  // particles that a system has room for besides

recording::Birth snow(float width) {
  using actions::Distribution;
  recording::Birth birth;
  birth.kind = recording::Birth::Kind::source;
  birth.shape = {shapes::Kind::rectangle, {-width / 2, 12, -4, width, 0, 0, 0, 0, 8}};
  Distribution velocity;
  velocity.kind = Distribution::Kind::shape;
  velocity.shape = {shapes::Kind::box, {-0.4, -1.4, -0.3, 0.4, -1.2, 0.3}};
  birth.state = {{particles::velocity, velocity}, {particles::age, {}}};
  return birth;
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
  std::array<std::vector<double>, 5> seconds;
  Store system(schema);
  for (int i = 0; i < repeats; ++i) {
    double start = comm::cpu_seconds();
    const auto lap = [&](std::size_t what) {
      const double now = comm::cpu_seconds();
      seconds[what].push_back(now - start);
      start = now;
    };
    Store newborn = recording::make(birth, schema, particles::system_key(1, 0), static_cast<std::uint64_t>(i) * count,
                                    count, 1.0f / 24, false, 0);
    lap(0);
    const std::vector<BirthBatch> made(1, BirthBatch(0, std::move(newborn), domains));
    lap(1);
    std::vector<comm::Message> messages = split(made, ring, 0);
    lap(2);
    std::vector<BirthBatch> between(1, BirthBatch(0, schema));
    join(messages, between);
    messages = split(between, ring, std::max(ring.steps() - 1, 0));
    lap(3);
    if (system.size() > kOld) system = Store(schema);
    system.reserve(kOld + count);
    start = comm::cpu_seconds();
    for (const comm::Message& message : messages) {
      particles::Reader in = message.reader();
      take(in, 0, system);
    }
    lap(4);
  }
  const auto each = [&](std::size_t what) { return 1e9 * recording::median(seconds[what]) / births; };
  return {each(0), each(1), each(2), each(3), each(4)};
}

}  // namespace motes::frame
