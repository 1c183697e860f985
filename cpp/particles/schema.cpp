#include "particles/schema.h"

#include <cmath>
#include <stdexcept>

#include "base/invalid_argument.h"

namespace motes::particles {
namespace {

bool identifier(std::string_view name) {
  if (name.empty() || (name[0] >= '0' && name[0] <= '9')) return false;
  for (const char c : name) {
    const bool word = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
    if (!word) return false;
  }
  return true;
}

}  // namespace

Schema::Schema() {
  for (const BuiltinAttribute& builtin : kBuiltins) add(builtin.name, builtin.width, builtin.initial);
}

int Schema::add(const std::string& name, int width, Value initial) {
  if (!identifier(name) || name == "id") {
    throw base::InvalidArgument("attribute name", "be an identifier other than id", "'" + name + "'");
  }
  if (find(name) >= 0) throw std::invalid_argument("attribute '" + name + "' already exists");
  if (width != 1 && width != 3 && size() >= builtin_count) {
    throw base::InvalidArgument("attribute '" + name + "'", "have 1 or 3 numbers", std::to_string(width));
  }
  if (size() == 64) throw std::invalid_argument("a system can have at most 64 attributes");
  attributes_.push_back({name, width, initial, components_});
  components_ += width;
  return size() - 1;
}

void Schema::set_periods(const Periods& periods) {
  if (!periods.any()) return;
  for (int axis = 0; axis < 3; ++axis) {
    const Period& period = periods[axis];
    const bool finite = std::isfinite(period.low) && std::isfinite(period.high);
    if (periods.has(axis) && !(finite && period.low < period.high)) {
      throw std::invalid_argument("a periodic axis must have its low end below its high end");
    }
  }
  const int found = find(kCrossings);
  if (found < 0 || (*this)[found].width != 3) {
    throw std::invalid_argument("a system in periodic space needs an attribute 'crossings' of 3 numbers");
  }
  periods_ = periods;
  crossings_ = found;
}

int Schema::attribute_of(int component) const {
  int attribute = 0;
  while (attribute + 1 < size() && attributes_[static_cast<std::size_t>(attribute + 1)].first_component <= component) {
    ++attribute;
  }
  return attribute;
}

int Schema::find(std::string_view name) const {
  for (int i = 0; i < size(); ++i) {
    if (attributes_[static_cast<std::size_t>(i)].name == name) return i;
  }
  return -1;
}

}  // namespace motes::particles
