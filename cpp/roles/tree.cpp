#include "roles/tree.h"

#include <algorithm>
#include <utility>

namespace motes::roles {
namespace {

using Range = Tree::Range;

// Splits the places below the head into up to `fan_out` ranges whose sizes differ by at most one.
std::vector<Range> divided(const Range& range, int fan_out) {
  const int rest = range.size() - 1;
  const int parts = std::min(rest, fan_out);
  std::vector<Range> found;
  int first = range.first + 1;
  for (int i = 0; i < parts; ++i) {
    const int end = first + rest / parts + (i < rest % parts ? 1 : 0);
    found.push_back({first, end, 0});
    first = end;
  }
  return found;
}

// Returns the levels below the head. The first range below a head is never smaller than the others.
int height_of(Range range, int fan_out) {
  int height = 0;
  for (; range.size() > 1; ++height) range = divided(range, fan_out).front();
  return height;
}

}  // namespace

Tree::Tree(const Cast& cast, int size, int fan_out, int self) : manager_(cast.calculator_of(cast.manager)) {
  std::vector<char> seated(static_cast<std::size_t>(size), 0);
  const auto seat = [&](int rank) {
    if (!std::exchange(seated[static_cast<std::size_t>(rank)], 1)) ranks_.push_back(rank);
  };
  seat(cast.manager);
  for (const int rank : cast.calculators) seat(rank);
  for (int rank = 0; rank < size; ++rank) seat(rank);
  const int place = static_cast<int>(std::find(ranks_.begin(), ranks_.end(), self) - ranks_.begin());
  own_ = {0, size, 0};
  parent_ = ranks_.front();
  height_ = height_of(own_, fan_out);
  while (own_.first != place) {
    parent_ = rank_at(own_.first);
    ++depth_;
    for (const Range& child : divided(own_, fan_out)) {
      if (place >= child.first && place < child.end) own_ = child;
    }
  }
  own_.height = height_of(own_, fan_out);
  children_ = divided(own_, fan_out);
  for (Range& child : children_) child.height = height_of(child, fan_out);
}

}  // namespace motes::roles
