// All kernels in all builds: the same particles give the same bits, whatever their numbers.
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "particles/schema.h"
#include "particles/store.h"
#include "support/check.h"
#include "support/isas.h"

namespace motes::test_kernels {
namespace {

using shapes::Kind;
using shapes::Shape;

int components_of_all() { return particles::Schema().components(); }

Shape shape(Kind kind, std::initializer_list<float> numbers) {
  Shape s;
  s.kind = kind;
  std::size_t i = 0;
  for (const float number : numbers) s.number[i++] = number;
  return s;
}

std::vector<Shape> all_shapes() {
  return {shape(Kind::point, {1, 2, 3}),
          shape(Kind::line, {0, 0, 0, 1, 2, 3}),
          shape(Kind::rectangle, {-1, 0, -1, 2, 0.3f, 0, 0, 0.1f, 2}),
          shape(Kind::disc, {0, 0, 0, 1, 2, 3, 2, 0.5f}),
          shape(Kind::plane, {0, -0.5f, 0, 0.1f, 1, 0.2f}),
          shape(Kind::box, {-1, -1, -1, 1, 1, 1}),
          shape(Kind::sphere, {0, 0, 0, 1.5f, 0.5f}),
          shape(Kind::triangle, {-1, 0, -1, 2, 0.3f, 0, 0, 0.1f, 2}),
          shape(Kind::cylinder, {0, -1, 0, 0.5f, 1, 0, 1.5f, 0.5f}),
          shape(Kind::cone, {0, -1, 0, 0.5f, 1, 0, 1.5f, 0}),
          shapes::unite({shape(Kind::box, {-1, -1, -1, 0, 1, 1}), shape(Kind::disc, {1, 0, 0, 1, 2, 3, 2, 0.5f})})};
}

// Returns a random number, now and then one that arithmetic may trip over.
float odd_number(test::Dice& dice) {
  constexpr float kInf = std::numeric_limits<float>::infinity();
  const float odd[] = {std::numeric_limits<float>::quiet_NaN(), kInf,  -kInf,  0.0f, -0.0f, 1e-40f, -3e-42f,
                       std::numeric_limits<float>::max(),       1e30f, -1e30f, 1.0f, 1e-30f};
  return dice.below(12) == 0 ? odd[dice.below(std::size(odd))] : dice.between(-3, 3);
}

struct Particles {
  std::size_t count;
  std::vector<std::vector<float>> planes;
  particles::IdList ids;
  std::vector<std::uint32_t> dead;  // one bit per particle

  Particles(std::size_t n, test::Dice& dice) : count(n), dead(n / 32 + 2) {
    for (int c = 0; c < components_of_all(); ++c) {
      planes.emplace_back(n + 16);
      for (float& value : planes.back()) value = odd_number(dice);
    }
    std::vector<std::uint64_t> whole(n + 16);
    for (std::uint64_t& id : whole) id = dice.word() >> (n % 2 == 0 ? 0 : 32);  // with upper halves and without
    ids = particles::IdList(whole);
  }
  actions::Block block(std::vector<float*>& components) {
    components.clear();
    for (std::vector<float>& plane : planes) components.push_back(plane.data());
    return {count, components.data(), ids, dead.data()};
  }
  bool died(std::size_t i) const { return (dead[i / 32] >> i % 32 & 1u) != 0; }
};

// Compares bits, but treats all NaNs as equal: processors choose their payload by the order of operands.
bool same(float a, float b) {
  return (std::isnan(a) && std::isnan(b)) || std::bit_cast<std::uint32_t>(a) == std::bit_cast<std::uint32_t>(b);
}

bool same(const Particles& a, const Particles& b) {
  for (std::size_t c = 0; c < a.planes.size(); ++c) {
    for (std::size_t i = 0; i < a.count; ++i) {
      if (!same(a.planes[c][i], b.planes[c][i])) return false;
    }
  }
  for (std::size_t i = 0; i < a.count; ++i) {
    if (a.died(i) != b.died(i)) return false;
  }
  return true;
}

std::vector<double> numbers_for(const actions::Facts& facts, test::Dice& dice) {
  std::vector<double> numbers;
  for (const actions::Number& number : facts.numbers) {
    const double low = std::fmax(number.low, -9);
    const double high = std::fmin(number.high, 9);
    for (int i = 0; i < number.count; ++i) {
      const double part = static_cast<double>(dice.between(0, 1));
      const bool flag = number.low == 0 && number.high == 1 && dice.coin();
      const double value = flag ? std::round(part) : low + (high - low) * part;
      numbers.push_back(number.rule == actions::Number::Rule::whole ? std::round(value) : value);
    }
  }
  if (dice.coin() && facts.name == std::string("damping")) numbers[4] = std::numeric_limits<double>::infinity();
  const int knots = facts.ramp > 0 ? 1 + static_cast<int>(dice.word() % 20) : 0;
  for (int knot = 0; knot < knots; ++knot) {
    numbers.push_back((knot + knot % 2) / 20.0);  // some knots make jumps
    for (int i = 0; i < facts.ramp; ++i) numbers.push_back(static_cast<double>(dice.between(0, 9)));
  }
  return numbers;
}

// The table of an action's kernel: a small grid, or a path of three segments.
struct SmallTable {
  std::vector<float> values;
  actions::TableView view;

  SmallTable(const actions::Facts& facts, test::Dice& dice) {
    const bool path = facts.name == std::string("follow_path");
    const int sizes[3] = {path ? 3 : 2, path ? 1 : 3, path ? 1 : 1 + static_cast<int>(dice.below(2))};
    values.resize(static_cast<std::size_t>(sizes[0] * sizes[1] * sizes[2] * facts.table));
    view = {values.data(), {sizes[0], sizes[1], sizes[2]}};
    for (float& v : values) v = dice.between(-2, 2);
    for (std::size_t row = 0; path && row < 3; ++row) {  // one behind the other, each a metre long
      const float fixed[] = {0.6f, 0, 0.8f, static_cast<float>(row), 1};
      std::copy(std::begin(fixed), std::end(fixed), values.begin() + static_cast<std::ptrdiff_t>(8 * row + 3));
    }
  }
};

// velocity.x += sin(position.y / age) dt; swaps position.x and age.
struct SmallLaw {
  expressions::Formula formula;
  std::vector<actions::LawResult> outcomes;
  std::vector<float> memory;
  std::vector<float*> planes;
  actions::LawCode code;

  SmallLaw() {
    using expressions::Op;
    const int age = particles::first_component(particles::age), x = 0, speed = 3;
    const std::vector<expressions::Expression> values = {
        {{Op::column, 1}, {Op::column, age}, {Op::divide}, {Op::sine}}, {{Op::column, age}}, {{Op::column, x}}};
    formula = expressions::compile(values, particles::Schema().components());
    outcomes = {{speed, formula.results[0], true, true}, {x, formula.results[1]}, {age, formula.results[2]}};
    memory.resize(static_cast<std::size_t>(formula.written()) * actions::kPlane);
    planes.resize(static_cast<std::size_t>(formula.planes));
    for (int p = formula.columns; p < formula.planes; ++p) {
      planes[static_cast<std::size_t>(p)] =
          memory.data() + static_cast<std::size_t>(p - formula.columns) * actions::kPlane;
    }
    code = {formula.constants.data(),
            formula.constants.size(),
            formula.steps.data(),
            formula.steps.size(),
            outcomes.data(),
            outcomes.size(),
            static_cast<std::size_t>(formula.columns),
            planes.data()};
  }
};

constexpr std::size_t kCounts[] = {1, 3, 5, 15, 16, 17, 31, 64, 100, 127, 128};

}  // namespace

TEST(actions_give_the_same_bits_in_every_build) {
  test::Dice dice(11);
  const auto builds = test::builds();
  for (const std::size_t count : kCounts) {
    for (int k = 0; k < actions::kKinds; ++k) {
      const actions::Facts& facts = actions::facts(static_cast<actions::Kind>(k));
      if (facts.between) continue;  // no kernel over a block
      for (const Shape& s : all_shapes()) {
        const std::vector<double> numbers = numbers_for(facts, dice);
        const std::vector<Shape> shapes(static_cast<std::size_t>(facts.shapes) + 1, s);
        actions::Parameters parameters{};
        parameters.number = numbers.data();
        parameters.shape = shapes.data();
        const bool turns = dice.coin();
        const SmallTable table(facts, dice);
        const SmallLaw law;
        const actions::AssignmentCode nothing;
        actions::Bound& bound = parameters.bound;
        bound.turns = {turns, false};
        if (facts.ramp > 0) bound.ramp = static_cast<int>(numbers.size());
        if (facts.table > 0) bound.table = &table.view;
        if (std::holds_alternative<actions::ParticleLaw>(facts.specifics)) bound.law = &law.code;
        if (std::holds_alternative<actions::Assignment>(facts.specifics)) bound.assignment = &nothing;
        particles::DrawKeys draws;
        const actions::Step step{0.04f,
                                 static_cast<std::uint32_t>(dice.word()),
                                 0x10003u,
                                 {static_cast<std::uint32_t>(dice.word()), 7},
                                 0,
                                 &draws,
                                 0,
                                 1,
                                 actions::ageing_of(0.04, 0, 1)};
        const Particles before(count, dice);
        Particles first = before;
        std::vector<float*> components;
        builds[0].kernels.action[k](parameters, first.block(components), step);
        for (const test::Build& build : builds) {
          Particles other = before;
          build.kernels.action[k](parameters, other.block(components), step);
          if (!same(first, other)) check::fail(facts.name, static_cast<int>(count), "differs in " + build.name);
        }
        if (facts.shapes == 0) break;  // one shape is enough
      }
    }
  }
}

TEST(births_give_the_same_bits_in_every_build) {
  using namespace actions::distributions;
  test::Dice dice(12);
  Uniform uniform;
  Normal normal;
  for (int i = 0; i < 3; ++i) {
    uniform.low[i] = normal.mean[i] = dice.between(-2, 0);
    uniform.high[i] = normal.sigma[i] = dice.between(0, 2);
  }
  std::vector<actions::Distribution> draws{Value{{1, -2, 3}}, uniform, normal};
  uniform.alike = normal.alike = true;
  draws.insert(draws.end(), {uniform, normal});
  for (const Shape& s : all_shapes()) draws.emplace_back(InShape{s});
  const auto builds = test::builds();
  for (const std::size_t count : kCounts) {
    for (const actions::Distribution& d : draws) {
      for (const int width : {1, 3}) {
        if (width == 1 && std::holds_alternative<InShape>(d)) continue;
        particles::DrawKeys draws;
        const actions::Step step{0.04f, 0, 0x105u, {static_cast<std::uint32_t>(dice.word()), 3}, 0, &draws};
        const Particles before(count, dice);
        Particles first = before;
        std::vector<float*> components;
        builds[0].kernels.draw(d, nullptr, step, first.ids, count, first.block(components).component, width);
        builds[0].kernels.jitter(first.block(components), step);
        for (const test::Build& build : builds) {
          Particles other = before;
          build.kernels.draw(d, nullptr, step, other.ids, count, other.block(components).component, width);
          build.kernels.jitter(other.block(components), step);
          if (!same(first, other)) check::fail("births", static_cast<int>(count), "differ in " + build.name);
        }
      }
    }
  }
}

TEST(contains_and_collect_agree_in_every_build) {
  test::Dice dice(13);
  const auto builds = test::builds();
  for (const std::size_t count : kCounts) {
    Particles p(count, dice);
    for (std::uint32_t& word : p.dead) {  // few bits in some words, many in others, also beyond the last particle
      word = static_cast<std::uint32_t>(dice.word()) & (dice.coin() ? ~0u : 1u << dice.below(32));
    }
    std::vector<float*> components;
    const actions::Block block = p.block(components);
    for (const Shape& s : all_shapes()) {
      std::vector<std::uint8_t> first(count), other(count);
      builds[0].kernels.contains(s, block.component, count, first.data());
      for (const test::Build& build : builds) {
        build.kernels.contains(s, block.component, count, other.data());
        CHECK(first == other);
      }
    }
    for (const test::Build& build : builds) {
      const std::size_t room = count + particles::kPadding;
      std::vector<std::uint32_t> dead(room), left(room), dead_wanted, left_wanted;
      std::size_t dead_count = 0, left_count = 0;
      const float* x = p.planes[0].data();
      const std::array<actions::Band, 1> bands{{{x, -1, 2}}};
      build.kernels.collect(block, bands.data(), bands.size(), 1000, dead.data(), dead_count, left.data(), left_count);
      for (std::size_t i = 0; i < count; ++i) {
        const auto index = static_cast<std::uint32_t>(1000 + i);
        if (p.died(i)) {
          dead_wanted.push_back(index);
        } else if (!(x[i] >= -1 && x[i] < 2)) {  // NaN is outside every domain
          left_wanted.push_back(index);
        }
      }
      dead.resize(dead_count);
      left.resize(left_count);
      CHECK(dead == dead_wanted);
      CHECK(left == left_wanted);
    }
  }
}

TEST(samples_lie_in_their_shapes) {
  const auto builds = test::builds();
  const std::size_t count = 4096;
  std::vector<std::uint64_t> numbers(count + 16);
  for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] = i;
  const particles::IdList ids(numbers);
  for (const Kind kind : {Kind::box, Kind::sphere}) {
    const Shape s = all_shapes()[static_cast<std::size_t>(kind)];
    const actions::distributions::InShape d{s};
    std::vector<std::vector<float>> planes(3, std::vector<float>(count + 16));
    float* into[3] = {planes[0].data(), planes[1].data(), planes[2].data()};
    particles::DrawKeys draws;
    builds.back().kernels.draw(d, nullptr, {0, 0, 1, {1, 2}, 0, &draws}, ids, count, into, 3);
    // Enlarged by a few rounding errors, since a sample may lie on the surface.
    Shape grown = s;
    if (kind == Kind::sphere) {
      grown.number[3] *= 1.00001f;
      grown.number[4] *= 0.99999f;
    }
    std::vector<std::uint8_t> inside(count);
    builds.back().kernels.contains(grown, into, count, inside.data());
    std::size_t held = 0;
    for (const std::uint8_t yes : inside) held += yes;
    CHECK(held == count);
  }
}

}  // namespace motes::test_kernels
