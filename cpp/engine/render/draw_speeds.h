// Measures how fast each rank draws, from its last tiles.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace motes::engine {

/// What one rank drew of a picture.
struct DrawSample {
  int rank = 0;
  double expected_s = 0;  // seconds at speed 1
  double seconds = 0;     // time it took, s
};

/// Smooths a number that varies from picture to picture; before = 0: not known.
double smoothed(double before, double now);

/// Speeds relative to the mean of all that draw: 1 until something else is known. They are smoothed over pictures, and
/// small changes count for nothing: where all ranks are alike, tiles stay with their owners.
class DrawSpeeds {
 public:
  /// Adds the samples of one picture; ranks that drew next to nothing do not count.
  void add(std::span<const DrawSample> samples);

  double of(std::size_t rank) const { return rank < speeds_.size() ? speeds_[rank].used : 1; }

  /// Returns how many times as long as expected all ranks take together; 1 until known.
  double slowness() const { return slowness_ > 0 ? slowness_ : 1; }

 private:
  struct Speed {
    double smooth = 0;  // 0: not known
    double used = 1;
  };
  std::vector<Speed> speeds_;  // by rank
  double slowness_ = 0;        // 0: not known
};

}  // namespace motes::engine
