#include "recording/record.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iomanip>
#include <sstream>

#include "actions/action.h"
#include "base/fields.h"
#include "base/invalid_argument.h"

namespace motes::recording {
namespace {

/// Counts numbers of two calls that differ.
class NumberDifference {
 public:
  template <class T>
  void see(const std::vector<T>& ours, const std::vector<T>& theirs) {
    if (ours.size() != theirs.size()) others_ = true;
    for (std::size_t i = 0; i < ours.size() && i < theirs.size(); ++i) {
      ++all_;
      const auto a = static_cast<double>(ours[i]), b = static_cast<double>(theirs[i]);
      if (ours[i] == theirs[i] || (std::isnan(a) && std::isnan(b))) continue;
      const double part = std::fabs(a - b) / std::max(std::fabs(a), std::fabs(b));
      if (different_++ > 0 && !(part > most_)) continue;
      most_ = part;
      a_ = a;
      b_ = b;
    }
  }

  bool last_bits() const {
    constexpr double kLastBits = 1e-5;  // of float32, after some operations
    return different_ > 0 && !others_ && most_ < kLastBits;
  }

  std::string text() const {
    if (different_ == 0 || others_) return {};
    std::ostringstream text;
    text << ": " << different_ << " of " << all_ << " numbers differ, as " << std::setprecision(9) << a_ << " here and "
         << b_ << " there";
    if (last_bits()) {
      text << ": only in their last bits. NumPy's exp, log, power, tan and the like differ between processors and "
              "versions; the functions of motes.expressions take arrays, too, and give the same bits everywhere";
    }
    return text.str();
  }

 private:
  std::size_t all_ = 0, different_ = 0;
  double most_ = 0, a_ = 0, b_ = 0;
  bool others_ = false;  // sizes differ
};

const Emit* emit_of(const Item& item) {
  const auto* birth = std::get_if<Birth>(&item);
  return birth == nullptr ? nullptr : std::get_if<Emit>(birth);
}

// Compares two items of the same kind.
std::string number_difference(const Item& ours, const Item& theirs) {
  NumberDifference difference;
  if (const auto* a = std::get_if<actions::Action>(&ours)) {
    difference.see(a->numbers, std::get<actions::Action>(theirs).numbers);
    if (!difference.last_bits()) return {};
  } else if (const Emit* emit = emit_of(ours)) {
    const Emit& other = *emit_of(theirs);
    for (std::size_t i = 0; i < emit->columns.size() && i < other.columns.size(); ++i)
      difference.see(emit->columns[i].values, other.columns[i].values);
  }
  return difference.text();
}

std::string list_difference(const std::string& system, const std::vector<Item>& ours, const std::vector<Item>& theirs) {
  for (std::size_t i = 0; i < ours.size() || i < theirs.size(); ++i) {
    const std::string place = "system '" + system + "', call " + std::to_string(i + 1) + ": ";
    if (i >= ours.size()) return place + "nothing here, " + name(theirs[i]) + " there";
    if (i >= theirs.size()) return place + name(ours[i]) + " here, nothing there";
    if (ours[i] == theirs[i]) continue;
    const std::string a = name(ours[i]);
    const std::string b = name(theirs[i]);
    if (a != b || ours[i].index() != theirs[i].index()) return place + a + " here, " + b + " there";
    return place + a + " with different arguments" + number_difference(ours[i], theirs[i]);
  }
  return {};
}

}  // namespace

particles::Schema schema_of(const SystemDefinition& system) {
  particles::Schema schema;
  for (const UserAttribute& attribute : system.attributes) {
    schema.add(attribute.name, attribute.width, attribute.initial);
  }
  schema.set_periods(system.periods);
  return schema;
}

std::string name(const actions::Action& action) { return actions::call_of(action.kind); }
std::string name(const Callback& callback) { return "callback " + callback.name; }
std::string name(const Spawn&) { return "spawn"; }
std::string name(const Read&) { return "local"; }
std::string name(const KeepCopies&) { return "a sum of birth values"; }

std::string name(const Item& item) {
  return std::visit([](const auto& kind) { return name(kind); }, item);
}

bool is_call(const Item& item) {
  return !std::holds_alternative<Read>(item) && !std::holds_alternative<KeepCopies>(item);
}

std::string name(Verb verb) {
  constexpr const char* kNames[] = {"entering the world",
                                    "render",
                                    "step",
                                    "digest",
                                    "gather",
                                    "total",
                                    "histogram",
                                    "tally",
                                    "write",
                                    "leaving the world",
                                    "redraw",
                                    "hearing viewers",
                                    "surface"};
  return kNames[static_cast<std::size_t>(verb)];
}

void write(const Record& record, base::Bytes& out) { base::write_fields(record, out); }

Record read(base::Reader& in) {
  Record record;
  base::read_fields(in, record);
  return record;
}

void check(const image::Sprite& sprite, const particles::Schema& schema) {
  image::check(sprite);
  if (sprite.sheet() == nullptr || sprite.sheet()->pick.number.empty()) return;
  const image::Pick& pick = sprite.sheet()->pick;
  const auto shapes = static_cast<int>(pick.shapes.size());
  if (expressions::check(pick.number, schema.components(), shapes) != expressions::Type::number) {
    throw base::InvalidArgument("pick", "be a number per particle");
  }
  if (actions::uses_copies(pick.number, schema)) throw base::InvalidArgument("pick", "not read *_b attributes");
}

std::string first_difference(const Record& ours, const Record& theirs) {
  if (ours.verb != theirs.verb) return name(ours.verb) + " here, " + name(theirs.verb) + " there";
  if (ours.frame != theirs.frame) {
    return "frame " + std::to_string(ours.frame) + " here, " + std::to_string(theirs.frame) + " there";
  }
  if (ours.seed != theirs.seed) return "a different seed";
  if (ours.dt != theirs.dt || ours.substeps != theirs.substeps) return "a different dt or substeps";
  if (ours.systems != theirs.systems) {
    if (ours.systems.size() != theirs.systems.size()) {
      return std::to_string(ours.systems.size()) + " systems here, " + std::to_string(theirs.systems.size()) + " there";
    }
    for (std::size_t i = 0; i < ours.systems.size(); ++i) {
      if (ours.systems[i] != theirs.systems[i]) return "system '" + ours.systems[i].name + "' is defined differently";
    }
  }
  for (std::size_t i = 0; i < ours.lists.size() && i < theirs.lists.size(); ++i) {
    const std::string difference = list_difference(ours.systems[i].name, ours.lists[i], theirs.lists[i]);
    if (!difference.empty()) return difference;
  }
  if (ours.sprites != theirs.sprites) return "a different sprite";
  if (ours.clumps != theirs.clumps) return "a different template of clumps";
  if (ours.view != theirs.view || ours.camera != theirs.camera) return "a different camera or renderer";
  if (ours.argument != theirs.argument)
    return "different arguments: " + ours.argument + " here, " + theirs.argument + " there";
  return "no difference in value";
}

}  // namespace motes::recording
