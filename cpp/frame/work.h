// Compute may fail, conversations may not: a failure is kept, later work of the turn is skipped, and the rank goes on
// talking with empty payloads until all have agreed on what happened.
#pragma once

#include "comm/clock.h"
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

inline Engine::Timed::Timed(Engine& engine, double& seconds, const char* phase, std::string system)
    : engine_(engine), seconds_(seconds), phase_(phase), system_(std::move(system)), start_(comm::wall_seconds()) {}

inline Engine::Timed::~Timed() {
  const double end = comm::wall_seconds();
  seconds_ += end - start_;
  if (engine_.spans_ && engine_.in_frame()) engine_.spans_->add(engine_.frame_, phase_, system_, start_, end);
}

// Seconds of work, by the clock that the run chose.
inline double Engine::compute_seconds() const {
  return options_.wall_clock ? comm::wall_seconds() : comm::cpu_seconds();
}

// What took this rank from `since` on takes a slower machine longer: spends the rest.
inline void Engine::slow_down(double since) const {
  if (options_.speed < 1) comm::spend((compute_seconds() - since) * (1 / options_.speed - 1));
}

// Work that takes so long on a machine of speed 1: time passes under a simulator, and nowhere else.
inline void Engine::charge(double nanoseconds) const { comm::execute(nanoseconds * options_.costs.scale); }

}  // namespace motes::frame
