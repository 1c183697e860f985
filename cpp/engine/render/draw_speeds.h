// How fast each rank draws, as its last tiles tell.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace motes::engine {

/// What one rank drew of a picture.
struct DrawSample {
  int rank = 0;
  double expected_s = 0;  // seconds at speed 1
  double seconds = 0;     // that it took
};

/// A number that differs from picture to picture, smoothed: what it was so far (0: not known) and what it is now.
double smoothed(double before, double now);

/// Speeds relative to the mean of all that draw: 1 until something else is known. They are smoothed over pictures, and
/// small changes count for nothing: where all ranks are alike, tiles stay with their owners.
class DrawSpeeds {
 public:
  /// Of one picture; ranks that drew next to nothing say nothing.
  void add(std::span<const DrawSample> samples);

  double of(std::size_t rank) const { return rank < speeds_.size() ? speeds_[rank].used : 1; }

  /// How many times as long as expected all take together: 1 until something is known.
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
