#include "actions/action.h"

#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "particles/schema.h"

namespace motes::actions {
namespace {

constexpr double kAny = 1e15;  // float32 can still square it
constexpr double kInf = std::numeric_limits<double>::infinity();

constexpr std::uint32_t bit(particles::Builtin attribute) { return 1u << attribute; }
constexpr std::uint32_t kPosition = bit(particles::position);
constexpr std::uint32_t kVelocity = bit(particles::velocity);
constexpr std::uint32_t kUp = bit(particles::up);
constexpr std::uint32_t kSpin = bit(particles::rotational_velocity);
constexpr std::uint32_t kAge = bit(particles::age);
constexpr std::uint32_t kLifetime = bit(particles::lifetime);

// Registration: one line an action, in the order of Kind.
const std::array<Facts, kKinds>& table() {
  // clang-format off
  static const std::array<Facts, kKinds> all = {{
      {"gravity", {{"acceleration", -kAny, kAny}, {"acceleration", -kAny, kAny}, {"acceleration", -kAny, kAny}}, 0,
       kVelocity, kVelocity, false},
      {"damping",
       {{"damping", 0, kAny}, {"damping", 0, kAny}, {"damping", 0, kAny}, {"min_speed", 0, kInf}, {"max_speed", 0, kInf}},
       0, kVelocity, kVelocity, false},
      {"random_acceleration", {}, 1, kVelocity, kVelocity, false},
      {"random_velocity", {}, 1, 0, kVelocity, false},
      {"bounce", {{"restitution", 0, kAny}, {"friction", 0, 1}, {"min_tangential_speed", 0, kInf}}, 1,
       kPosition | kVelocity, kPosition | kVelocity, false},
      {"sink", {{"inside", 0, 1}}, 1, kPosition, 0, true},
      {"kill_old", {{"age_limit", -kInf, kInf}, {"younger", 0, 1}}, 0, kAge, 0, true},
      {"kill_expired", {}, 0, kAge | kLifetime, 0, true},
      {"move", {{"rotational", 0, 1}}, 0, kPosition | kVelocity | kAge | kUp | kSpin, kPosition | kAge | kUp, false},
      {"set", {}, 0, 0, 0, false},  // what it touches depends on its expressions
  }};
  // clang-format on
  return all;
}

std::string text(double value) {
  std::string digits = std::to_string(value);
  if (digits.find('.') != std::string::npos) {
    while (digits.back() == '0') digits.pop_back();
    if (digits.back() == '.') digits.push_back('0');
  }
  return digits;
}

void check_number(const Facts& facts, const Number& number, double value) {
  if (value >= number.low && value <= number.high) return;
  throw std::invalid_argument(std::string(facts.name) + ": " + number.name + " must be " + text(number.low) + ".." +
                              text(number.high) + ", got " + text(value));
}

// The first shape, among it and its parts, that has nothing to meet.
const shapes::Shape* without_surface(const shapes::Shape& shape) {
  using shapes::Kind;
  for (int i = 0; i < shape.parts; ++i) {
    if (const shapes::Shape* found = without_surface(shape.part[i])) return found;
  }
  return shape.kind == Kind::point || shape.kind == Kind::line || shape.kind == Kind::blob ? &shape : nullptr;
}

}  // namespace

const Facts& facts(Kind kind) { return table()[static_cast<std::size_t>(kind)]; }

Kind kind_of(const std::string& name) {
  for (int i = 0; i < kKinds; ++i) {
    if (name == table()[static_cast<std::size_t>(i)].name) return static_cast<Kind>(i);
  }
  throw std::invalid_argument("no action is called '" + name + "'");
}

namespace {

std::uint64_t columns_of(const Expression& expression, const particles::Schema& schema) {
  std::uint64_t mask = 0;
  for (const Instruction& instruction : expression) {
    if (instruction.op == Op::inside) mask |= kPosition;
    if (instruction.op == Op::column) mask |= std::uint64_t{1} << schema.attribute_of(instruction.index);
  }
  return mask;
}

}  // namespace

std::uint64_t reads(const Action& action, const particles::Schema& schema) {
  std::uint64_t mask = facts(action.kind).reads | columns_of(action.where, schema);
  for (const Expression& value : action.values) mask |= columns_of(value, schema);
  return mask;
}

std::uint64_t writes(const Action& action, const particles::Schema& schema) {
  (void)schema;
  const std::uint64_t mask = facts(action.kind).writes;
  return action.target >= 0 ? mask | std::uint64_t{1} << action.target : mask;
}

bool uses_copies(const Action& action, const particles::Schema& schema) {
  constexpr std::uint64_t kCopies = bit(particles::position_b) | bit(particles::velocity_b) | bit(particles::up_b);
  return ((reads(action, schema) | writes(action, schema)) & kCopies) != 0;
}

void check(const Action& action, const particles::Schema& schema) {
  const auto number_of_shapes = static_cast<int>(action.shapes.size());
  const auto check_type = [&](const Expression& expression, Type wanted, const char* what) {
    if (check(expression, schema.components(), number_of_shapes) != wanted) throw std::invalid_argument(what);
  };
  if (!action.where.empty()) check_type(action.where, Type::truth, "where must be a shape or a comparison");
  if ((action.kind == Kind::set) != (action.target >= 0)) throw std::invalid_argument("set must name an attribute");
  if (action.target < 0) return;
  if (action.target >= schema.size() || static_cast<int>(action.values.size()) != schema[action.target].width) {
    throw std::invalid_argument("set must give an attribute of the system as many numbers as it has");
  }
  for (const Expression& value : action.values) check_type(value, Type::number, "set must give numbers");
}

void check(const Action& action) {
  const Facts& known = facts(action.kind);
  if (action.numbers.size() != known.numbers.size() || static_cast<int>(action.shapes.size()) < known.shapes) {
    throw std::invalid_argument(std::string(known.name) + ": wrong count of numbers or shapes");
  }
  for (std::size_t i = 0; i < action.numbers.size(); ++i) check_number(known, known.numbers[i], action.numbers[i]);
  for (const shapes::Shape& shape : action.shapes) shapes::check(shape);
  if (action.kind == Kind::damping && action.numbers[3] > action.numbers[4]) {
    throw std::invalid_argument("damping: min_speed must not be above max_speed, got " + text(action.numbers[3]) +
                                " > " + text(action.numbers[4]));
  }
  const shapes::Shape* wrong = action.kind == Kind::bounce ? without_surface(action.shapes[0]) : nullptr;
  if (wrong != nullptr)
    throw std::invalid_argument("bounce: shape must have a surface, got a " + shapes::name(wrong->kind));
}

}  // namespace motes::actions
