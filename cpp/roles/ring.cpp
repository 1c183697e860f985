#include "roles/ring.h"

namespace motes::roles {

Ring::Ring(int calculators, int self) : calculators_(calculators), self_(self) {
  while ((calculators_ - 1) >> (kBits * steps_) > 0) ++steps_;
}

std::vector<int> Ring::ahead(int step) const {
  std::vector<int> found;
  for (int j = 1; j < 1 << kBits && j << (kBits * step) < calculators_; ++j) {
    found.push_back((self_ + (j << (kBits * step))) % calculators_);
  }
  return found;
}

std::vector<int> Ring::behind(int step) const {
  std::vector<int> found;
  for (int j = 1; j < 1 << kBits && j << (kBits * step) < calculators_; ++j) {
    found.push_back((self_ + calculators_ - (j << (kBits * step))) % calculators_);
  }
  return found;
}

}  // namespace motes::roles
