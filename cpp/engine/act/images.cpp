#include "engine/act/images.h"

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <string>

#include "engine/act/ghosts.h"

namespace motes::engine {

namespace {

domains::Box shifted(domains::Box box, const std::array<double, 3>& by) {
  for (std::size_t c = 0; c < 3; ++c) {
    box.low[c] = static_cast<float>(static_cast<double>(box.low[c]) + by[c]);
    box.high[c] = static_cast<float>(static_cast<double>(box.high[c]) + by[c]);
  }
  return box;
}

}  // namespace

Images::Images(const particles::Periods& periods) : periods_(periods), shifts_{{0, 0, 0}} {
  for (int axis = 0; axis < 3; ++axis) {
    if (!periods.has(axis)) continue;
    const std::size_t count = shifts_.size();
    for (const int way : {1, -1}) {
      for (std::size_t i = 0; i < count; ++i) {
        shifts_.push_back(shifts_[i]);
        shifts_.back()[static_cast<std::size_t>(axis)] = way * periods[axis].length();
      }
    }
  }
}

float Images::farthest_end() const {
  float most = 0;
  for (int axis = 0; axis < 3; ++axis) {
    if (periods_.has(axis)) most = std::max({most, -periods_[axis].low, periods_[axis].high});
  }
  return most;
}

domains::BoxCover Images::ends(domains::BoxCover cover) const {
  const auto limit = [&](domains::Box& box) {
    for (std::size_t c = 0; c < 3; ++c) {
      if (!periods_.has(static_cast<int>(c))) continue;
      box.low[c] = std::max(box.low[c], periods_.along[c].low);
      box.high[c] = std::min(box.high[c], periods_.along[c].high);
    }
  };
  std::for_each(cover.boxes.begin(), cover.boxes.end(), limit);
  limit(cover.around);
  return cover;
}

bool Images::within(const domains::BoxCover& a, const domains::BoxCover& b, double range) const {
  for (const std::array<double, 3>& shift : shifts_) {
    if (!(gap(shifted(a.around, shift), b.around) <= range)) continue;
    for (const domains::Box& own : a.boxes) {
      const domains::Box box = shifted(own, shift);
      const auto near = [&](const domains::Box& other) { return gap(box, other) <= range; };
      if (std::any_of(b.boxes.begin(), b.boxes.end(), near)) return true;
    }
  }
  return false;
}

double Images::outside(const domains::BoxCover& cover, const float (&x)[3]) const {
  double least = std::numeric_limits<double>::infinity();
  for (std::uint8_t number = 0; number < count(); ++number) {
    const float place[3] = {at(number, 0, x[0]), at(number, 1, x[1]), at(number, 2, x[2])};
    for (const domains::Box& box : cover.boxes) least = std::min(least, engine::outside(box, place));
  }
  return least;
}

float Images::most_skin(float reach) const {
  float most = std::numeric_limits<float>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    if (periods_.has(axis)) most = std::min(most, 0.499f * static_cast<float>(periods_[axis].length()) - reach);
  }
  return std::max(most, 0.0f);
}

void Images::check(const interactions::PairAction& action, float reach) const {
  using AcrossEnds = interactions::PairAction::AcrossEnds;
  if (!any() || action.across_ends() == AcrossEnds::nearest_partners) return;
  const std::string name = action.name();
  if (action.across_ends() == AcrossEnds::refused) {
    throw std::invalid_argument(name + " does not work across the boundaries of periodic space");
  }
  for (int axis = 0; axis < 3; ++axis) {
    if (!periods_.has(axis)) continue;
    const double most = periods_[axis].length() / 2 * (1 + 1e-6);  // tolerates the rounding of float32 radii
    if (static_cast<double>(reach) <= most) continue;
    throw std::invalid_argument(name + " reaches " + std::to_string(reach) +
                                " m; in periodic space it must be at most " +
                                std::to_string(periods_[axis].length() / 2) + " m, half a period");
  }
}

}  // namespace motes::engine
