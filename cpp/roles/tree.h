// The tree along which messages between the manager and all ranks travel, so that no rank talks to more than a few
// others.
#pragma once

#include <vector>

#include "roles/cast.h"

namespace motes::roles {

/// Places 0, 1, ... in the tree: the manager is the root, the calculators follow in the order of their domains, then
/// the ranks that do not calculate. All places below a place come right after it: place p heads the range p .. end - 1.
/// An image generator that does not calculate has no rank below it, so it delays nobody while it waits for a picture.
class Tree {
 public:
  struct Range {
    int first = 0;  // the place at its head
    int end = 0;
    int height = 0;  // levels below the head
    int size() const { return end - first; }
  };

  /// The tree as rank `self` sees it. A place has at most `fan_out` children; with fan_out >= size - 1 all ranks are
  /// the manager's children.
  Tree(const Cast& cast, int size, int fan_out, int self);

  int rank_at(int place) const { return ranks_[static_cast<std::size_t>(place)]; }
  int size() const { return static_cast<int>(ranks_.size()); }

  /// This rank's place and all places below it.
  const Range& own() const { return own_; }
  bool root() const { return own_.first == 0; }
  bool leaf() const { return children_.empty(); }
  int parent() const { return parent_; }  // a rank; the root is its own parent
  int depth() const { return depth_; }
  int height() const { return height_; }  // of the whole tree
  const std::vector<Range>& children() const { return children_; }

  /// Returns the place of a calculator, given its number.
  int place_of(int calculator) const {
    return calculator == manager_ ? 0 : calculator + 1 - (manager_ >= 0 && calculator > manager_ ? 1 : 0);
  }
  /// Returns whether a calculator is in a range.
  bool holds(const Range& range, int calculator) const {
    const int place = place_of(calculator);
    return place >= range.first && place < range.end;
  }
  /// Returns how many calculators of this rank's own range come before this one, which must be in the range.
  int row_of(int calculator) const {
    return place_of(calculator) - own_.first - (own_.first == 0 && manager_ < 0 ? 1 : 0);
  }

 private:
  std::vector<int> ranks_;
  int manager_ = -1;  // the manager's number as a calculator; -1: it is none
  Range own_;
  int parent_ = 0;
  int depth_ = 0;
  int height_ = 0;
  std::vector<Range> children_;
};

}  // namespace motes::roles
