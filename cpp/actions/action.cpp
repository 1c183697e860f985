#include "actions/action.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "base/invalid_argument.h"
#include "particles/schema.h"

namespace motes::actions {
namespace {

using rules::kAny;
using rules::kInf;

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
constexpr std::uint32_t kContacts = bit(particles::contacts);
constexpr std::uint32_t kTorn = bit(particles::torn);
constexpr std::uint32_t kOrientation = bit(particles::orientation);
constexpr std::uint32_t kWorldSpin = bit(particles::spin);
constexpr std::uint32_t kHits = bit(particles::hit) | bit(particles::hit_normal) | bit(particles::landing);

const std::array<Facts, kKinds>& table() {
  static const std::array<Facts, kKinds> all = {{
#define MOTES_NUMBER(rule, name, ...) rules::rule(#name __VA_OPT__(, ) __VA_ARGS__),
#define MOTES_ACTION(action, given, ...) \
  {.name = #action, .numbers = {MOTES_EACH_NUMBER(given)} __VA_OPT__(, ) __VA_ARGS__},
#define MOTES_INTERACTION(action, family, given, ...) \
  {.name = #action, .numbers = {MOTES_EACH_NUMBER(given)}, __VA_ARGS__, .between = true},
#include "actions/list.inc"
#undef MOTES_INTERACTION
#undef MOTES_ACTION
#undef MOTES_NUMBER
  }};
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

std::string call_of(const Facts& facts) { return facts.call != nullptr ? facts.call : facts.name; }

void check_number(const Facts& facts, const Number& number, double value) {
  if (value >= number.low && value <= number.high) return;
  throw base::InvalidArgument(number.name, "be " + text(number.low) + ".." + text(number.high), text(value),
                              call_of(facts));
}

[[noreturn]] void refuse(const std::string& call, const std::string& argument, const std::string& rule,
                         const std::string& got = "") {
  throw base::InvalidArgument(argument, rule, got, call);
}

[[noreturn]] void refuse(const Facts& facts, const std::string& argument, const std::string& rule,
                         const std::string& got = "") {
  refuse(call_of(facts), argument, rule, got);
}

// Kernels divide by the squared length in float32, so it must be a normal number.
void check_axis(const Facts& facts, const Number& number, const double* v) {
  const double square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
  if (!(square > 1e-30 && square < 1e30)) {
    refuse(facts, std::string(number.name), "not be zero, and must be shorter than 1e15");
  }
}

using Rule = Number::Rule;

void check_rule(const Facts& facts, const Number* number, const double* value) {
  switch (number->rule) {
    case Rule::none: break;
    case Rule::axis: check_axis(facts, *number, value); break;
    case Rule::whole:
      if (std::trunc(*value) != *value) {
        refuse(facts, std::string(number->name), "be a whole number", text(*value));
      }
      break;
    case Rule::not_below_last:
      if (value[-1] > value[0]) {
        refuse(facts, std::string(number[-1].name), std::string("not be above ") + number->name,
               text(value[-1]) + " > " + text(value[0]));
      }
      break;
  }
}

void check_numbers(const Facts& facts, const std::vector<double>& numbers) {
  std::size_t at = 0;
  for (const Number& number : facts.numbers) {
    if (at + static_cast<std::size_t>(number.count) > numbers.size())
      refuse(facts, "numbers", "match the action's number of parameters", std::to_string(numbers.size()));
    for (int i = 0; i < number.count; ++i) check_number(facts, number, numbers[at + static_cast<std::size_t>(i)]);
    check_rule(facts, &number, &numbers[at]);
    at += static_cast<std::size_t>(number.count);
  }
  if (at != numbers.size())
    refuse(facts, "numbers", "match the action's number of parameters", std::to_string(numbers.size()));
}

void check_ramp(const Facts& facts, const std::vector<double>& numbers) {
  const std::size_t row = 1 + static_cast<std::size_t>(facts.ramp);
  if (numbers.empty() || numbers.size() % row != 0)
    refuse(facts, "ramp", "have at least one knot, and no incomplete knot");
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    check_number(facts, i % row == 0 ? rules::part("ramp's age / lifetime") : rules::any("ramp's value"), numbers[i]);
    if (i >= row && i % row == 0 && numbers[i] < numbers[i - row]) refuse(facts, "ramp", "be in ascending order");
  }
}

// Returns the first shape without a surface, among this one and its parts; null if all have one.
const shapes::Shape* without_surface(const shapes::Shape& shape) {
  for (int i = 0; i < shape.parts; ++i) {
    if (const shapes::Shape* found = without_surface(shape.part[i])) return found;
  }
  return shapes::has_surface(shape.kind) ? nullptr : &shape;
}

void check_surface(const Facts& facts, const shapes::Shape& shape) {
  const shapes::Shape* wrong = without_surface(shape);
  if (wrong != nullptr) refuse(facts, "shape", "have a surface", "a " + shapes::name(wrong->kind));
}

void check_wall(const Facts& facts, const WallNumbers& wall) {
  const std::pair<std::string, double> values[] = {{"stiffness", wall.stiffness},
                                                   {"restitution", wall.restitution},
                                                   {"friction", wall.friction},
                                                   {"rolling_friction", wall.rolling_friction}};
  for (const auto& [name, value] : values) {
    for (const Number& number : facts.numbers) {
      if (name == number.name) check_number(facts, number, value);
    }
  }
}

void check_table(const Facts& facts, TableKey key) {
  if ((facts.table != 0) != (key != 0)) refuse(facts, "table", facts.table != 0 ? "be given" : "not be given");
  if (key != 0 && actions::table(key)->width != facts.table) {
    refuse(facts, "each entry of its table", "have " + std::to_string(facts.table) + " numbers");
  }
}

// Checks that a clump has positive moments and 1 to kMostSpheres spheres with positive radii.
void check_clump(const Action& action, TableKey clump) {
  const LookupTable& spheres = *actions::table(clump);
  for (const double moment : numbers_of<numbers::contact_clumps>(action).moments) {
    if (!(moment > 0)) refuse("clumps", "moments", "be above 0", text(moment));
  }
  const std::size_t count = spheres.values.size() / 4;
  if (count == 0 || count > kMostSpheres)
    refuse("clumps", "template", "have 1.." + std::to_string(kMostSpheres) + " spheres", std::to_string(count));
  for (std::size_t i = 0; i < count; ++i) {
    if (!(spheres.values[4 * i + 3] > 0)) refuse("clumps", "template", "have radii above 0");
  }
}

}  // namespace

void check_kind(const Action& action, Kind kind, std::size_t count) {
  if (action.kind == kind && action.numbers.size() == count) return;
  throw std::logic_error(std::string("the numbers of ") + facts(kind).name + " were requested from " +
                         facts(action.kind).name + ", size " + std::to_string(action.numbers.size()));
}

const Facts& facts(Kind kind) { return table()[static_cast<std::size_t>(kind)]; }

std::string call_of(Kind kind) { return call_of(facts(kind)); }

Kind kind_of(const std::string& name) {
  for (int i = 0; i < kKinds; ++i) {
    if (name == table()[static_cast<std::size_t>(i)].name) return static_cast<Kind>(i);
  }
  throw std::invalid_argument("no action is called '" + name + "'");
}

const Specifics& specifics_of(Kind kind) { return facts(kind).specifics; }

numbers::contact<double> contact_of(const Action& action) {
  return read_numbers<numbers::contact, double>(action.numbers.data());
}

int states_of(const Action& action) {
  return action.kind == Kind::interact ? static_cast<int>(numbers_of<numbers::interact>(action).state) : 0;
}

bool reads_here(const Action& action, const Leaf& leaf) {
  if (leaf.of == Leaf::Of::own) return !action.second();
  return leaf.of == Leaf::Of::other && (action.second() || !action.partner);
}

std::uint64_t columns_of(const Expression& expression, const particles::Schema& schema) {
  std::uint64_t mask = 0;
  for (const Instruction& instruction : expression) {
    if (instruction.op == Op::inside) mask |= kPosition;
    if (instruction.op == Op::column) mask |= std::uint64_t{1} << schema.attribute_of(instruction.index);
  }
  return mask;
}

std::uint64_t named(const Action& action, const particles::Schema& schema) {
  std::uint64_t mask = columns_of(action.where, schema);
  std::visit(
      [&](const auto& part) {
        if constexpr (requires { part.leaves; }) {
          for (const Leaf& leaf : part.leaves) {
            if (reads_here(action, leaf)) mask |= std::uint64_t{1} << leaf.attribute;
          }
        } else if constexpr (requires { part.values; }) {
          for (const Expression& value : part.values) mask |= columns_of(value, schema);
        }
      },
      action.specifics);
  return mask;
}

std::uint64_t reads(const Action& action, const particles::Schema& schema) {
  return facts(action.kind).reads | named(action, schema);
}

std::uint64_t writes(const Action& action) {
  std::uint64_t mask = facts(action.kind).writes;
  std::visit(
      [&](const auto& part) {
        if constexpr (requires { part.attribute; }) mask |= std::uint64_t{1} << part.attribute;
        if constexpr (requires { part.results; }) {
          for (const Result& result : part.results) {
            if (result.how != Result::How::state && !action.second()) mask |= std::uint64_t{1} << result.attribute;
          }
        }
      },
      action.specifics);
  return mask;
}

constexpr std::uint64_t kCopies = kPositionB | kVelocityB | kUpB;

bool uses_copies(const Expression& expression, const particles::Schema& schema) {
  return (columns_of(expression, schema) & kCopies) != 0;
}

bool uses_copies(const Action& action, const particles::Schema& schema) {
  return ((reads(action, schema) | writes(action)) & kCopies) != 0;
}

namespace {

bool exists(const particles::Schema& schema, std::int32_t attribute, std::int32_t component) {
  return attribute >= 0 && attribute < schema.size() && component >= 0 && component < schema[attribute].width;
}

void check_leaf(const Action& action, const Leaf& leaf, const particles::Schema& schema) {
  const Facts& law = facts(action.kind);
  switch (leaf.of) {
    case Leaf::Of::own:
    case Leaf::Of::other:
      if (reads_here(action, leaf) && !exists(schema, leaf.attribute, leaf.component))
        refuse(law, "an expression", "read existing attributes");
      break;
    case Leaf::Of::distance:
      if (leaf.component != 0) refuse(law, "a distance", "be one number");
      break;
    case Leaf::Of::normal:
      if (leaf.component < 0 || leaf.component > 2) refuse(law, "a normal", "have three components");
      break;
    case Leaf::Of::state:
      if (leaf.component < 0 || leaf.component >= states_of(action)) refuse(law, "an expression", "read known states");
      break;
  }
}

// Checks the results of a script's law, and that each has a value over `columns`.
void check_results(const Action& action, const std::vector<Result>& results, const std::vector<Expression>& values,
                   int columns, int shapes, const particles::Schema& schema) {
  const Facts& law = facts(action.kind);
  if (results.empty()) refuse(law, "results", "be given");
  if (values.size() != results.size()) refuse(law, "values", "be one per result");
  for (const Result& result : results) {
    const bool known = result.how == Result::How::state
                           ? result.component >= 0 && result.component < states_of(action)
                           : action.second() || exists(schema, result.attribute, result.component);
    if (!known) refuse(law, "results", "go to existing attributes and states");
  }
  for (const Expression& value : values) {
    if (check(value, columns, shapes) != expressions::Type::number) refuse(law, "values", "be numbers");
  }
}

int count_of(const std::vector<shapes::Shape>& shapes) { return static_cast<int>(shapes.size()); }

}  // namespace

void Assignment::check(const Action& action, const particles::Schema& schema) const {
  if (attribute < 0) throw base::InvalidArgument("set", "name an attribute");
  if (attribute >= schema.size() || static_cast<int>(values.size()) != schema[attribute].width) {
    throw base::InvalidArgument("set", "give an attribute of the system one number per component");
  }
  for (const Expression& value : values) {
    if (expressions::check(value, schema.components(), count_of(action.shapes)) != expressions::Type::number)
      throw std::invalid_argument("set must give numbers");
  }
}

void PerParticle::check(const Action& action, const particles::Schema& schema) const {
  const Facts& known = facts(action.kind);
  int wanted = 0;
  for (const Number& number : facts(kind_of(known.call)).numbers) wanted += number.count;
  if (static_cast<int>(values.size()) != wanted)
    refuse(known, "values", "be " + std::to_string(wanted), std::to_string(values.size()));
  for (const Expression& value : values) {
    if (expressions::check(value, schema.components(), count_of(action.shapes)) != expressions::Type::number)
      refuse(known, "values", "be numbers");
  }
}

void ParticleLaw::check(const Action& action, const particles::Schema& schema) const {
  check_results(action, results, values, schema.components(), count_of(action.shapes), schema);
}

void PairLaw::check(const Action& action, const particles::Schema& schema) const {
  for (const Leaf& leaf : leaves) check_leaf(action, leaf, schema);
  if (std::any_of(values.begin(), values.end(), expressions::names_ids))
    refuse(facts(action.kind), "an expression", "not read ids");
  check_results(action, results, values, static_cast<int>(leaves.size()), 0, schema);
}

void Lookup::check(const Action& action) const { check_table(facts(action.kind), table); }

void Grains::check(const Action& action) const {
  const Facts& known = facts(action.kind);
  check_table(known, clump);
  const std::string count = std::to_string(walls.size());
  if (walls.size() > kMostWalls) refuse(known, "walls", "be at most " + std::to_string(kMostWalls), count);
  if (action.shapes.size() < walls.size()) refuse(known, "walls", "be at most the number of shapes", count);
  for (std::size_t i = 0; i < walls.size(); ++i) {
    const shapes::Shape* wrong = without_surface(action.shapes[i]);
    if (wrong != nullptr) refuse(known, "walls", "have surfaces", "a " + shapes::name(wrong->kind));
    check_wall(known, walls[i]);
  }
  if (clump != 0) check_clump(action, clump);
}

void check(const Action& action, const particles::Schema& schema) {
  if (!action.where.empty() &&
      check(action.where, schema.components(), count_of(action.shapes)) != expressions::Type::truth) {
    throw std::invalid_argument("where must be a shape or a comparison");
  }
  std::visit(
      [&](const auto& part) {
        if constexpr (requires { part.check(action, schema); }) part.check(action, schema);
      },
      action.specifics);
}

void check_condition(const Expression& where, const std::vector<shapes::Shape>& shapes,
                     const particles::Schema& schema) {
  for (const shapes::Shape& shape : shapes) shapes::check_region(shape);
  if (!where.empty() &&
      check(where, schema.components(), static_cast<int>(shapes.size())) != expressions::Type::truth) {
    throw base::InvalidArgument("where", "be a shape or a comparison");
  }
}

void check(const Action& action) {
  const Facts& known = facts(action.kind);
  if (known.ramp > 0) {
    check_ramp(known, action.numbers);
  } else {
    check_numbers(known, action.numbers);
  }
  if (static_cast<int>(action.shapes.size()) < known.shapes)
    refuse(known, "shapes", "be " + std::to_string(known.shapes), std::to_string(action.shapes.size()));
  for (std::size_t i = 0; i < action.shapes.size(); ++i) {
    const bool drawn = known.draws && static_cast<int>(i) == known.shapes - 1;
    drawn ? shapes::check(action.shapes[i]) : shapes::check_region(action.shapes[i]);
  }
  if (known.needs_surface) check_surface(known, action.shapes[0]);
  if (action.specifics.index() != known.specifics.index()) refuse(known, "its parts", "be those of its kind");
  std::visit(
      [&](const auto& part) {
        if constexpr (requires { part.check(action); }) part.check(action);
      },
      action.specifics);
}

}  // namespace motes::actions
