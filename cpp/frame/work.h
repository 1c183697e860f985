// Compute may fail, conversations may not: a failure is kept, later work of the turn is skipped, and the rank goes on
// talking with empty payloads until all have agreed on what happened.
#pragma once

#include "frame/engine.h"
#include "simd/float_mode.h"

namespace motes::frame {

template <class Work>
void Engine::work(const std::string& action, const Work& compute) {
  if (failure_.failed()) return;
  const simd::FloatMode mode;
  try {
    compute();
  } catch (const std::exception& error) {
    failure_ = {Failure::Kind::compute, action, error.what()};
    own_exception_ = std::current_exception();
  }
}

}  // namespace motes::frame
