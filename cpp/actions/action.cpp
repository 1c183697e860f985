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

bool has_surface(shapes::Kind kind) { return kind != shapes::Kind::point && kind != shapes::Kind::line; }

}  // namespace

const Facts& facts(Kind kind) { return table()[static_cast<std::size_t>(kind)]; }

Kind kind_of(const std::string& name) {
  for (int i = 0; i < kKinds; ++i) {
    if (name == table()[static_cast<std::size_t>(i)].name) return static_cast<Kind>(i);
  }
  throw std::invalid_argument("no action is called '" + name + "'");
}

bool uses_copies(const Action& action) {
  constexpr std::uint32_t kCopies = bit(particles::position_b) | bit(particles::velocity_b) | bit(particles::up_b);
  return ((facts(action.kind).reads | facts(action.kind).writes) & kCopies) != 0;
}

void check(const Action& action) {
  const Facts& known = facts(action.kind);
  if (action.numbers.size() != known.numbers.size() || static_cast<int>(action.shapes.size()) != known.shapes) {
    throw std::invalid_argument(std::string(known.name) + ": wrong count of numbers or shapes");
  }
  for (std::size_t i = 0; i < action.numbers.size(); ++i) check_number(known, known.numbers[i], action.numbers[i]);
  for (const shapes::Shape& shape : action.shapes) shapes::check(shape);
  if (action.kind == Kind::damping && action.numbers[3] > action.numbers[4]) {
    throw std::invalid_argument("damping: min_speed must not be above max_speed, got " + text(action.numbers[3]) +
                                " > " + text(action.numbers[4]));
  }
  if (action.kind == Kind::bounce && !has_surface(action.shapes[0].kind)) {
    throw std::invalid_argument("bounce: shape must be a Plane, Rectangle, Disc, Box or Sphere, got a " +
                                shapes::name(action.shapes[0].kind));
  }
}

}  // namespace motes::actions
