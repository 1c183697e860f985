// How calculators send something to each other, all to all, in two steps of few messages.
#pragma once

#include <vector>

namespace motes::roles {

/// Calculators 0, 1, ... row by row in a grid; the last row may be short. What calculator c has for d goes along c's
/// row to d's column, and down the column to d. Up to 16 of them are one row: all messages are direct.
class Grid {
 public:
  explicit Grid(int calculators);

  bool direct() const { return columns_ == calculators_; }
  int columns() const { return columns_; }

  /// The calculators that c sends to in the first step: one a column. Those for d is at place d % columns().
  std::vector<int> along(int c) const;
  /// Those that send to c in the first step.
  std::vector<int> from_along(int c) const;
  /// The calculators of c's column, in order: each sends to each in the second step.
  std::vector<int> column(int c) const;

 private:
  int via(int c, int column) const;

  int calculators_;
  int columns_;
};

}  // namespace motes::roles
