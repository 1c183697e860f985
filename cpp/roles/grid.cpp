#include "roles/grid.h"

namespace motes::roles {
namespace {

constexpr int kDirect = 16;

int columns_for(int calculators) {
  if (calculators <= kDirect) return calculators;
  int columns = 1;
  while (columns * columns < calculators) ++columns;
  return columns;
}

}  // namespace

Grid::Grid(int calculators) : calculators_(calculators), columns_(columns_for(calculators)) {}

// Where the last row has no such column, the row above it steps in.
int Grid::via(int c, int column) const {
  const int there = c / columns_ * columns_ + column;
  return there < calculators_ ? there : there - columns_;
}

std::vector<int> Grid::along(int c) const {
  std::vector<int> found;
  for (int column = 0; column < columns_; ++column) found.push_back(via(c, column));
  return found;
}

std::vector<int> Grid::from_along(int c) const {
  std::vector<int> found;
  const int row = c / columns_ * columns_;
  for (int from = row; from < row + 2 * columns_ && from < calculators_; ++from) {
    if (via(from, c % columns_) == c) found.push_back(from);
  }
  return found;
}

std::vector<int> Grid::column(int c) const {
  std::vector<int> found;
  for (int at = c % columns_; at < calculators_; at += columns_) found.push_back(at);
  return found;
}

}  // namespace motes::roles
