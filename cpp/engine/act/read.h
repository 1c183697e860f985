// Reads in the middle of a frame: what was recorded so far runs first. A read does not change the frame's result.
#pragma once

#include <memory>

#include "engine/session/rank.h"
#include "engine/state/population.h"
#include "engine/state/script.h"

namespace motes::engine {

/// Particles of this rank as a script reads them: the first `count` of a store. The script's writes take effect unless
/// the store is a preview; for previews see keep_preview.
struct ParticlesView {
  particles::Store* store;
  std::size_t count;
  bool preview;
};

/// Throws std::invalid_argument, on all ranks, if the items recorded so far contain interactions: a single rank cannot
/// run those.
void check_readable(const System& system);

/// Returns the result of the last read, or the particles as they are.
ParticlesView seen(Population& here);

/// Runs the items recorded so far for a system that check_readable() accepts, on this rank only, without communication:
/// each calculator creates the births of its own domain. The rest of the list runs at the frame's end. With sub-steps a
/// list cannot run in parts, so it runs on a copy that is dropped at the frame's end.
ParticlesView read(Rank& rank, Script& script, Calculator& calculator, int system);

/// Call after a read on all ranks: if this rank has failed, marks its list as the read would have, so its list matches
/// the others' and the failure is not taken for a mismatch.
void pass_over(const Rank& rank, System& system);

/// Makes the preview the system's particles, on all ranks, because the script writes to it. All sub-steps of the list
/// so far have then run before the rest. Views of the preview stay valid. If this rank fails, its list still matches
/// the others'.
void keep_preview(Rank& rank, Script& script, Calculator& calculator, int system);

/// Puts the *_b attributes into use because the next read uses them, and records that for runs of the list without the
/// script.
void read_copies(System& system, Population& here);

/// Computes the digest of `seen` for the next report. Collective, after read().
void note_digest(const Rank& rank, const ParticlesView& seen, Population& here);

/// Returns all particles on rank 0, or on every rank; null elsewhere. Not sorted. Particles are sent to rank 0
/// directly, or to all ranks along a ring. Collective, in a conversation of verb gather.
std::unique_ptr<particles::Store> gather(Rank& rank, const System& system, const ParticlesView& seen, bool to_all);

}  // namespace motes::engine
