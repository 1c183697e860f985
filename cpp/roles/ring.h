// All-to-all communication between calculators in few messages.
#pragma once

#include <cstddef>
#include <vector>

namespace motes::roles {

/// Calculators 0, 1, ... on a ring: what c has for d must travel (d - c) mod n places ahead. In step s a calculator
/// sends everything whose distance has the digit j at place s, in base 16, to the calculator j * 16^s ahead. Each step
/// settles one digit, so everything has arrived after log16(n) steps with at most 15 messages each, for any n (Bruck et
/// al. 1997, "Efficient algorithms for all-to-all communications in multiport message-passing systems"). With up to 16
/// calculators one step suffices: all messages are direct.
class Ring {
  static constexpr int kBits = 4;  // per digit; with more bits there are fewer steps, each with more messages

 public:
  static constexpr std::size_t kDigits = std::size_t{1} << kBits;  // values of a digit

  /// The ring as calculator `self` sees it.
  Ring(int calculators, int self);

  int steps() const { return steps_; }
  /// Returns which of the step's messages takes something from here to `owner`: 0: none, it stays; 1: the one to the
  /// first of ahead(step).
  int digit(int owner, int step) const {
    int distance = owner - self_;
    distance += calculators_ & (distance >> 31);  // no branch, which would be mispredicted half the time
    return distance >> (kBits * step) & ((1 << kBits) - 1);
  }
  /// Returns the calculators that this one sends to in a step, for digits 1, 2, ...
  std::vector<int> ahead(int step) const;
  /// Returns the calculators that send to this one in a step.
  std::vector<int> behind(int step) const;

 private:
  int calculators_;
  int self_;
  int steps_ = 0;
};

}  // namespace motes::roles
