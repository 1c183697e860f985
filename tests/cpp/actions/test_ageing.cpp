// Growth of ages (actions/ageing.h): exact at the borders of frames, for any step, sub-steps and age.
#include <bit>
#include <cmath>
#include <limits>
#include <vector>

#include "actions/ageing.h"
#include "particles/schema.h"
#include "support/check.h"
#include "support/isas.h"

namespace motes::test_ageing {
namespace {

constexpr double kSteps[] = {1.0 / 24, 1.0 / 30, 0.1, 1001.0 / 30000, 1e-3, 0.7, 1.0 / 64};
constexpr int kSubsteps[] = {1, 2, 3, 20, 200};

/// Moves resting particles by the sub-steps `first`.. of a frame; returns their ages.
std::vector<float> aged(const actions::Kernels& kernels, std::vector<float> ages, double dt, int substeps,
                        int first = 0) {
  const std::size_t count = ages.size(), padded = count + particles::kPadding;
  std::vector<float> still(padded);
  ages.resize(padded);
  std::vector<float*> planes(static_cast<std::size_t>(particles::Schema().components()), still.data());
  planes[static_cast<std::size_t>(particles::Schema()[particles::age].first_component)] = ages.data();
  std::vector<std::uint32_t> dead(padded / 32 + 1);
  const double numbers[] = {0};
  actions::Parameters parameters{};
  parameters.number = numbers;
  for (int substep = first; substep < substeps; ++substep) {
    actions::Step step{static_cast<float>(dt / substeps), 0, 0, {}};
    step.ageing = actions::ageing_of(dt, substep, substeps);
    kernels.action[static_cast<std::size_t>(actions::Kind::move)](parameters, {count, planes.data(), {}, dead.data()},
                                                                  step);
  }
  ages.resize(count);
  return ages;
}

// Returns numbers of steps: the first ones, those around powers of two, and random ones.
std::vector<double> numbers_of_steps(test::Dice& dice, int bits) {
  std::vector<double> numbers;
  for (int n = 0; n < 300; ++n) numbers.push_back(n);
  for (int n = 1; n < bits; ++n) {
    for (int off = -1; off <= 1; ++off) numbers.push_back(std::ldexp(1, n) + off);
  }
  for (int n = 0; n < 300; ++n) numbers.push_back(std::floor(std::ldexp(dice.between(0, 1), bits)));
  return numbers;
}

std::vector<float> times(const std::vector<double>& numbers, double dt, double more = 0) {
  std::vector<float> ages;
  for (const double number : numbers) ages.push_back(static_cast<float>((number + more) * dt));
  return ages;
}

}  // namespace

TEST(ages_are_the_frames_times_their_length_after_days_of_film) {
  test::Dice dice(1);
  for (const double dt : kSteps) {
    for (const int substeps : kSubsteps) {
      const std::vector<double> frames = numbers_of_steps(dice, 21);
      CHECK(aged(actions::kernels(), times(frames, dt), dt, substeps) == times(frames, dt, 1));
    }
  }
}

TEST(ages_of_births_in_any_sub_step_are_the_sub_steps_times_their_length) {
  test::Dice dice(2);
  for (const double dt : kSteps) {
    for (const int substeps : kSubsteps) {
      std::vector<double> parts = numbers_of_steps(dice, 22);
      for (double& part : parts) part /= substeps;
      const int first = static_cast<int>(dice.below(static_cast<std::size_t>(substeps)));
      const double more = static_cast<double>(substeps - first) / substeps;
      std::vector<double> then;
      for (const double part : parts) then.push_back(std::round(part * substeps + substeps - first) / substeps);
      CHECK(aged(actions::kernels(), times(parts, dt), dt, substeps, first) == times(then, dt));
      CHECK(aged(actions::kernels(), {0}, dt, substeps, first) == times({0}, dt, more));
    }
  }
}

TEST(ages_that_began_anywhere_stay_within_four_units_of_their_last_place) {
  test::Dice dice(3);
  std::vector<float> start(400);
  for (std::size_t i = 0; i < start.size(); ++i) start[i] = dice.between(i % 2 == 0 ? 0.0f : -20.0f, 2);
  for (const int substeps : {1, 7}) {
    const double dt = 1.0 / 24;
    std::vector<float> ages = start;
    for (int frame = 1; frame <= 3000; ++frame) {
      ages = aged(actions::kernels(), ages, dt, substeps);
      if (frame % 50 != 0) continue;
      for (std::size_t i = 0; i < start.size(); ++i) {
        const double exact = static_cast<double>(start[i]) + frame * dt;
        const float largest = std::fmax(std::fabs(start[i]), static_cast<float>(std::fabs(exact)));
        const float unit = std::nextafter(largest, std::numeric_limits<float>::infinity()) - largest;
        CHECK(std::fabs(static_cast<double>(ages[i]) - exact) <= 4 * static_cast<double>(unit));
      }
    }
  }
}

TEST(ages_that_are_no_numbers_stay_so_and_huge_ones_grow_as_sums_do) {
  constexpr float kInf = std::numeric_limits<float>::infinity();
  const std::vector<float> odd = {kInf, -kInf, 3e38f, -3e38f, 1e20f, -1e20f, 0.0f, -0.0f, 1e-42f};
  for (const int substeps : {1, 3}) {
    const std::vector<float> older = aged(actions::kernels(), odd, 0.25, substeps);
    for (std::size_t i = 0; i < odd.size(); ++i) CHECK(older[i] == odd[i] + 0.25f);
    CHECK(std::isnan(aged(actions::kernels(), {std::nanf("")}, 0.25, substeps)[0]));
  }
}

TEST(ages_have_the_same_bits_in_every_build) {
  test::Dice dice(4);
  std::vector<float> ages(1000);
  for (float& age : ages) age = std::ldexp(dice.between(-1, 1), static_cast<int>(dice.below(60)) - 20);
  ages[7] = std::numeric_limits<float>::infinity();
  ages[70] = -ages[7];
  for (const double dt : kSteps) {
    for (const int substeps : kSubsteps) {
      const std::vector<float> first = aged(actions::kernels(), ages, dt, substeps);
      for (const test::Build& build : test::builds()) CHECK(aged(build.kernels, ages, dt, substeps) == first);
    }
  }
}

}  // namespace motes::test_ageing
