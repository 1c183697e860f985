#include "roles/ring.h"

namespace motes::roles {
namespace {

constexpr int kDirect = 16;
constexpr int kDirectBits = 4;
constexpr int kBits = 3;

}  // namespace

Ring::Ring(int calculators, int self)
    : calculators_(calculators), self_(self), bits_(calculators <= kDirect ? kDirectBits : kBits) {
  while ((calculators_ - 1) >> (bits_ * steps_) > 0) ++steps_;
}

std::vector<int> Ring::ahead(int step) const {
  std::vector<int> found;
  for (int j = 1; j < 1 << bits_ && j << (bits_ * step) < calculators_; ++j) {
    found.push_back((self_ + (j << (bits_ * step))) % calculators_);
  }
  return found;
}

std::vector<int> Ring::behind(int step) const {
  std::vector<int> found;
  for (int j = 1; j < 1 << bits_ && j << (bits_ * step) < calculators_; ++j) {
    found.push_back((self_ + calculators_ - (j << (bits_ * step))) % calculators_);
  }
  return found;
}

}  // namespace motes::roles
