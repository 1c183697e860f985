// The state of a rank that every phase of a frame uses: settings, session, threads, machine, stopwatch.
#pragma once

#include <memory>
#include <utility>

#include "engine/session/machine.h"
#include "engine/session/session.h"
#include "engine/session/settings.h"
#include "engine/session/stopwatch.h"
#include "threads/pool.h"

namespace motes::engine {

struct Rank {
  Rank(std::unique_ptr<comm::Communicator> communicator, roles::Cast cast, Settings given)
      : settings(std::move(given)), session(std::move(communicator), std::move(cast)),
        pool(std::make_unique<threads::Pool>(settings.threads, settings.grain)), machine(settings, *pool),
        watch(session.comm().ledger()) {
    session.comm().ledger().one_thread(pool->threads() == 1);
    pool->meanwhile([this] { session.comm().progress(); });
  }
  Rank(const Rank&) = delete;
  Rank& operator=(const Rank&) = delete;

  /// Returns whether births are created in place: this rank is the manager and the only calculator, so no message is
  /// needed.
  bool creates_in_place() const { return session.manages() && session.calculator() == 0 && session.calculators() == 1; }

  /// Returns the start time of the current frame, in seconds of the animation.
  double frame_time() const { return static_cast<double>(session.frame) * settings.dt; }

  Settings settings;
  Session session;
  std::unique_ptr<threads::Pool> pool;  // only the thread that runs the frame communicates
  Machine machine;
  Stopwatch watch;
};

}  // namespace motes::engine
