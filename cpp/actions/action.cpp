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
constexpr std::uint32_t kColor = bit(particles::color);
constexpr std::uint32_t kAlpha = bit(particles::alpha);
constexpr std::uint32_t kSize = bit(particles::size);
constexpr std::uint32_t kMass = bit(particles::mass);
constexpr std::uint32_t kAge = bit(particles::age);
constexpr std::uint32_t kLifetime = bit(particles::lifetime);
constexpr std::uint32_t kPositionB = bit(particles::position_b);
constexpr std::uint32_t kVelocityB = bit(particles::velocity_b);
constexpr std::uint32_t kUpB = bit(particles::up_b);

constexpr Number vector(const char* name) { return {name, -kAny, kAny, 3}; }
constexpr Number any(const char* name) { return {name, -kAny, kAny}; }
constexpr Number positive(const char* name, int count = 1) { return {name, 0, kAny, count}; }
constexpr Number limit(const char* name) { return {name, 0, kInf}; }
constexpr Number part(const char* name) { return {name, 0, 1}; }

// Registration: one line an action, in the order of Kind.
const std::array<Facts, kKinds>& table() {
  // clang-format off
  static const std::array<Facts, kKinds> all = {{
      {"gravity", {vector("acceleration")}, 0, kVelocity, kVelocity},
      {"damping", {positive("damping", 3), limit("min_speed"), limit("max_speed")}, 0, kVelocity, kVelocity},
      {"random_acceleration", {}, 1, kVelocity, kVelocity},
      {"random_velocity", {}, 1, 0, kVelocity},
      {"bounce", {positive("restitution"), part("friction"), limit("min_tangential_speed"), part("exact_hit")}, 1,
       kPosition | kVelocity, kPosition | kVelocity},
      {"sink", {part("inside")}, 1, kPosition, 0, true},
      {"kill_old", {{"age_limit", -kInf, kInf}, part("younger")}, 0, kAge, 0, true},
      {"kill_expired", {}, 0, kAge | kLifetime, 0, true},
      {"move", {part("rotational")}, 0, kPosition | kVelocity | kAge | kUp | kSpin, kPosition | kAge | kUp},
      {"set", {}, 0, 0, 0},  // what it touches depends on its expressions
      {"avoid", {any("magnitude"), positive("epsilon"), positive("look_ahead")}, 1, kPosition | kVelocity, kVelocity},
      {"explosion", {vector("center"), positive("radius"), any("magnitude"), {"sigma", 1e-6, kAny}, positive("epsilon")},
       0, kPosition | kVelocity, kVelocity},
      {"jet", {}, 2, kPosition | kVelocity, kVelocity},
      {"orbit_point", {vector("center"), any("magnitude"), positive("epsilon"), limit("max_radius")}, 0,
       kPosition | kVelocity, kVelocity},
      {"orbit_line", {vector("point"), vector("axis"), any("magnitude"), positive("epsilon"), limit("max_radius")}, 0,
       kPosition | kVelocity, kVelocity},
      {"vortex", {vector("tip"), vector("axis"), positive("tightness"), limit("max_radius"), any("in_speed"),
       any("up_speed"), any("around_speed")}, 0, kPosition | kVelocity | kMass, kVelocity},
      {"random_displacement", {}, 1, kPosition, kPosition},
      {"random_rotational_velocity", {}, 1, 0, kSpin},
      {"rotational_damping", {positive("damping", 3), limit("min_speed"), limit("max_speed")}, 0, kSpin, kSpin},
      {"sink_velocity", {part("inside")}, 1, kVelocity, 0, true},
      {"speed_clamp", {positive("min_speed"), limit("max_speed")}, 0, kVelocity, kVelocity},
      {"target_color", {vector("color"), any("alpha"), positive("scale")}, 0, kColor | kAlpha, kColor | kAlpha},
      {"target_size", {vector("size"), positive("scale", 3)}, 0, kSize, kSize},
      {"target_velocity", {vector("velocity"), positive("scale")}, 0, kVelocity, kVelocity},
      {"target_rotational_velocity", {vector("rotational_velocity"), positive("scale")}, 0, kSpin, kSpin},
      {"restore", {any("time_left"), part("position"), part("up")}, 0,
       kPosition | kVelocity | kUp | kSpin | kPositionB | kUpB, kPosition | kVelocity | kUp | kSpin},
      {"copy_vertex_b", {part("position"), part("velocity")}, 0,
       kPosition | kVelocity | kUp, kPositionB | kVelocityB | kUpB},
      {"wind", {vector("velocity"), positive("drag")}, 0, kVelocity, kVelocity},
      {"color_over_life", {}, 0, kAge | kLifetime, kColor, false, 3},
      {"alpha_over_life", {}, 0, kAge | kLifetime, kAlpha, false, 1},
      {"size_over_life", {}, 0, kAge | kLifetime, kSize, false, 3},
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

[[noreturn]] void refuse(const Facts& facts, const std::string& what) {
  throw std::invalid_argument(std::string(facts.name) + ": " + what);
}

void check_numbers(const Facts& facts, const std::vector<double>& numbers) {
  std::size_t at = 0;
  for (const Number& number : facts.numbers) {
    for (int i = 0; i < number.count; ++i, ++at) {
      if (at >= numbers.size()) refuse(facts, "too few numbers");
      check_number(facts, number, numbers[at]);
    }
  }
  if (at != numbers.size()) refuse(facts, "too many numbers");
}

void check_ramp(const Facts& facts, const std::vector<double>& numbers) {
  const std::size_t row = 1 + static_cast<std::size_t>(facts.ramp);
  if (numbers.empty() || numbers.size() % row != 0)
    refuse(facts, "ramp must have at least one knot, all of them whole");
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    check_number(facts, i % row == 0 ? part("ramp's age / lifetime") : any("ramp's value"), numbers[i]);
    if (i >= row && i % row == 0 && numbers[i] < numbers[i - row]) refuse(facts, "ramp must be in ascending order");
  }
}

// Two numbers of an action, the first of which must not be above the second.
void check_range(const Facts& facts, double low, double high) {
  if (low > high) refuse(facts, "min_speed must not be above max_speed, got " + text(low) + " > " + text(high));
}

// The kernels divide by the float square of the length: it must be a normal number.
void check_axis(const Facts& facts, const double* axis) {
  const double square = axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2];
  if (!(square > 1e-30 && square < 1e30)) refuse(facts, "axis must not be zero, and shorter than 1e15");
}

// The first shape, among it and its parts, that has nothing to meet.
const shapes::Shape* without_surface(const shapes::Shape& shape) {
  using shapes::Kind;
  for (int i = 0; i < shape.parts; ++i) {
    if (const shapes::Shape* found = without_surface(shape.part[i])) return found;
  }
  return shape.kind == Kind::point || shape.kind == Kind::line || shape.kind == Kind::blob ? &shape : nullptr;
}

void check_surface(const Facts& facts, const shapes::Shape& shape) {
  const shapes::Shape* wrong = without_surface(shape);
  if (wrong != nullptr) refuse(facts, "shape must have a surface, got a " + shapes::name(wrong->kind));
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
  if (known.ramp > 0) {
    check_ramp(known, action.numbers);
  } else {
    check_numbers(known, action.numbers);
  }
  if (static_cast<int>(action.shapes.size()) < known.shapes) refuse(known, "too few shapes");
  for (const shapes::Shape& shape : action.shapes) shapes::check(shape);
  const std::vector<double>& n = action.numbers;
  switch (action.kind) {
    case Kind::damping:
    case Kind::rotational_damping: check_range(known, n[3], n[4]); break;
    case Kind::speed_clamp: check_range(known, n[0], n[1]); break;
    case Kind::orbit_line:
    case Kind::vortex: check_axis(known, &n[3]); break;
    case Kind::bounce:
    case Kind::avoid: check_surface(known, action.shapes[0]); break;
    default: break;
  }
}

}  // namespace motes::actions
