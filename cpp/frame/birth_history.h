// Where living particles came from, as long as nobody asked: births are functions of their ids, so their first values
// can be made once more when a script first names a *_b attribute.
#pragma once

#include <cstdint>
#include <vector>

#include "particles/random.h"
#include "particles/store.h"
#include "recording/births.h"

namespace motes::frame {

class BirthHistory {
 public:
  /// Notes particles first_id .. first_id + count - 1 of a call. dt: seconds of its (sub)step.
  void add(const recording::Birth& birth, std::uint64_t first_id, std::uint64_t count, float dt);

  /// Forgets calls of which no particle lives in `store`; looks only where that may free memory worth the work.
  void forget_dead(const particles::Store& store);

  /// Gives the particles of `store` the *_b values that they would have had from birth on, and forgets all.
  void restore_copies(particles::Store& store, particles::Key key);

  std::size_t size() const { return calls_.size(); }

 private:
  struct Call {
    recording::Birth birth;
    std::uint64_t first_id;
    std::uint64_t count;
    float dt;
  };
  std::vector<Call> calls_;  // ascending ids
  std::size_t bytes_ = 0;
  std::size_t bytes_kept_ = 0;  // when last looked
};

}  // namespace motes::frame
