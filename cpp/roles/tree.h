// Who passes words on to whom: conversations between the manager and all ranks go along a tree, so that nobody talks to
// more than a few others.
#pragma once

#include <vector>

#include "roles/cast.h"

namespace motes::roles {

/// Places 0, 1, ... in the tree: the manager is its root, the calculators follow in the order of their domains, then
/// the ranks that do not calculate. All that stand below a place follow it: place p heads the range p .. end - 1. The
/// image generator, if it does not calculate, has nobody below it: who waits for a picture holds nobody else up.
class Tree {
 public:
  struct Range {
    int first = 0;  // the place that heads it
    int end = 0;
    int height = 0;  // levels below the head
    int size() const { return end - first; }
  };

  /// As rank `self` sees it. A place has `fan_out` children at most; with fan_out >= size - 1 all are the manager's.
  Tree(const Cast& cast, int size, int fan_out, int self);

  int rank_at(int place) const { return ranks_[static_cast<std::size_t>(place)]; }
  int size() const { return static_cast<int>(ranks_.size()); }

  /// This rank's place and all below it.
  const Range& own() const { return own_; }
  bool root() const { return own_.first == 0; }
  bool leaf() const { return children_.empty(); }
  int parent() const { return parent_; }  // a rank; the root's is its own
  int depth() const { return depth_; }
  int height() const { return height_; }  // of the whole tree
  const std::vector<Range>& children() const { return children_; }

 private:
  std::vector<int> ranks_;
  Range own_;
  int parent_ = 0;
  int depth_ = 0;
  int height_ = 0;
  std::vector<Range> children_;
};

}  // namespace motes::roles
