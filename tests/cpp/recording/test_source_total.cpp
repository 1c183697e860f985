// Numbers of births compared with sums of whole numbers: rates that stay, change, pause, come in sub-steps or as
// integrals.
#include <cstdint>
#include <limits>
#include <random>
#include <vector>

#include "base/fields.h"
#include "engine/state/system.h"
#include "recording/source_total.h"
#include "support/check.h"

namespace motes::test_source_total {
using namespace recording;

namespace {

constexpr double kFilm = 1.0 / 24;

Source source_of(double rate, std::uint64_t number = 0) {
  Source source;
  source.rate = rate;
  source.number = number;
  return source;
}

engine::System system_of(std::uint64_t capacity = UINT64_MAX) {
  SystemDefinition definition;
  definition.name = "snow";
  definition.capacity = capacity;
  return {definition, 1, 0, 3};
}

// Returns how many particles the system creates in a frame of these calls.
std::uint64_t born_in_frame(engine::System& system, const std::vector<Source>& calls, int substeps = 1) {
  const std::uint64_t before = system.counts.born;
  system.start_frame();
  for (const Source& call : calls) system.list.emplace_back(call);
  system.count_births(kFilm, substeps);
  return system.counts.born - before;
}

}  // namespace

TEST(source_totals_do_not_drift_in_a_million_frames) {
  for (const auto& [rate, whole, parts] :
       {std::tuple{30.0, 30u, 24u}, {0.3, 3u, 240u}, {1.0, 1u, 24u}, {1e9, 1000000000u, 24u}}) {
    const Source source = source_of(rate);
    SourceTotal total;
    std::uint64_t wrong = 0;
    for (std::uint64_t frame = 1; frame <= 1000000; ++frame) {
      births_in_step(source, kFilm, 0, 1, &total);
      wrong += total.emitted == frame * whole / parts ? 0 : 1;
    }
    CHECK(wrong == 0);
  }
}

TEST(source_totals_are_sums_of_rates_that_change) {
  std::mt19937 random(1);
  for (const int substeps : {1, 3, 7}) {
    SourceTotal total;
    std::uint64_t sum = 0, wrong = 0;  // of thousandths per second
    for (int frame = 0; frame < 20000; ++frame) {
      const std::uint64_t rate = random() % 3 == 0 ? 0 : random() % 100000;
      const Source source = source_of(static_cast<double>(rate) / 1000);
      for (int substep = 0; substep < substeps; ++substep) {
        births_in_step(source, kFilm, substep, substeps, &total);
        sum += rate;
        wrong += total.emitted == sum / (24000u * static_cast<unsigned>(substeps)) ? 0 : 1;
      }
    }
    CHECK(wrong == 0 && total.emitted > 10000);
  }
}

TEST(source_totals_hold_rates_of_any_size) {
  SourceTotal total;
  std::uint64_t born = 0;
  for (const double rate : {24e12 / 24, 24.0 / 16, 1e-300, 24.0 / 16, 0.0, 24.0 / 8, 24.0 * 3 / 4, 24e10}) {
    born += births_in_step(source_of(rate), kFilm, 0, 1, &total);
  }
  CHECK(born == 41666666666 + 1 + 10000000000 && born == total.emitted);  // 41666666666.67 + 1/8 + 1/8 + 3/4 + 10^10
}

TEST(sources_keep_their_fractions_while_others_are_called) {
  engine::System system = system_of();
  // Halves of a particle: one source in frames 0, 2, 4, ..., the other in frames 0, 1, 2, ...
  std::vector<std::uint64_t> born;
  for (int frame = 0; frame < 8; ++frame) {
    std::vector<Source> calls{source_of(12, 2)};
    if (frame % 2 == 0) calls.insert(calls.begin(), source_of(12, 1));
    born.push_back(born_in_frame(system, calls));
  }
  CHECK((born == std::vector<std::uint64_t>{0, 1, 1, 1, 0, 1, 1, 1}));
  CHECK(system.sources.size() == 2 && system.sources[0].emitted == 2 && system.sources[1].emitted == 4);
}

TEST(sources_of_one_number_are_told_apart_by_their_order) {
  engine::System system = system_of();
  CHECK(born_in_frame(system, {source_of(12), source_of(12)}) == 0);
  CHECK(born_in_frame(system, {source_of(0), source_of(12)}) == 1);
  CHECK(born_in_frame(system, {source_of(12)}) == 1);
  CHECK(system.sources.size() == 2);
}

TEST(sources_count_in_each_part_of_a_list_once) {
  engine::System system = system_of();
  system.list = {source_of(36), source_of(36)};
  system.count_births(kFilm, 1);
  CHECK(system.groups.size() == 2 && system.counts.born == 2);
  system.mark_run();
  system.list.emplace_back(source_of(36));
  CHECK(system.next_birth(kFilm, 1).first == 3);
  CHECK(system.next_birth(kFilm, 1).first == 3);
  system.count_births(kFilm, 1);
  CHECK(system.groups.size() == 1 && system.counts.born == 3 && system.sources.size() == 3);
}

TEST(sources_lose_what_the_capacity_drops) {
  engine::System system = system_of(10);
  CHECK(born_in_frame(system, {source_of(24 * 12.5)}) == 10 && system.counts.dropped == 2);
  CHECK(born_in_frame(system, {source_of(24 * 12.5)}) == 10 && system.counts.dropped == 5);
}

TEST(source_totals_add_up_integrals) {
  Source source = source_of(0);
  engine::System system = system_of();
  source.integral = {0.25, 0.75, 1.5};  // of a rate that began before the source
  CHECK(born_in_frame(system, {source}, 2) == 1);
  CHECK(born_in_frame(system, {source_of(24 * 0.75)}, 2) == 1);  // a constant rate continues from there
  source.integral = {1e15, 1e15 + 0.5, 1e15 + 1};
  CHECK(born_in_frame(system, {source}, 2) == 1);
  source.integral = {3 - 1e-9, 3 - 1e-9, 3 - 1e-9};
  CHECK(born_in_frame(system, {source}, 2) == 0);
  source.integral = {0, 1 - 1e-13, 1 - 1e-13};
  CHECK(born_in_frame(system, {source}, 2) == 0);
  source.scale = 1000;  // now rounding errors are those of 1000
  source.integral = {0, 0, 0};
  CHECK(born_in_frame(system, {source}, 2) == 1);
}

TEST(source_totals_come_back) {
  engine::System system = system_of();
  born_in_frame(system, {source_of(10, 5), source_of(1.0 / 3, 5), source_of(7, UINT64_MAX)});
  for (const SourceTotal& total : system.sources) {
    base::Bytes bytes;
    base::write_fields(total, bytes);
    base::Reader in(bytes.view());
    SourceTotal read;
    base::read_fields(in, read);
    CHECK(read == total && in.done());
  }
}

TEST(integrals_of_rates_are_checked) {
  const particles::Schema schema;
  Source source = source_of(0);
  source.integral = {0, 4e9, 8e9};
  check(source, schema);
  for (const std::vector<double>& wrong : {std::vector<double>{0, 4.1e9},
                                           {-1, 0},
                                           {0, std::numeric_limits<double>::quiet_NaN()},
                                           {0, std::numeric_limits<double>::infinity()}}) {
    source.integral = wrong;
    CHECK_THROWS(check(source, schema), std::invalid_argument);
  }
  source.integral.clear();
  source.scale = -1;
  CHECK_THROWS(check(source, schema), std::invalid_argument);
}

}  // namespace motes::test_source_total
