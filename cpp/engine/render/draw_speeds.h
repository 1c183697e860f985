// Measures how fast each rank draws, from its last tiles.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace motes::engine {

/// A rank's drawing of its part of a picture.
struct DrawSample {
  int rank = 0;
  double expected_s = 0;  // seconds at speed 1
  double seconds = 0;     // measured
};

/// Returns `before` smoothed with a new sample; before = 0: not known.
double smoothed(double before, double now);

/// Drawing speeds relative to the mean of all drawing ranks; 1 until measured. They are smoothed over pictures, and
/// small changes are ignored, so tiles stay with their owners if all ranks are equally fast.
class DrawSpeeds {
 public:
  /// Adds the samples of one picture; samples that are too short are ignored.
  void add(std::span<const DrawSample> samples);

  double of(std::size_t rank) const { return rank < speeds_.size() ? speeds_[rank].used : 1; }

  /// Returns the measured time of all ranks divided by the expected one; 1 until known.
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
