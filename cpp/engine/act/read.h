// Reading in the middle of a frame: what was recorded so far runs first, and nothing that comes out changes by it.
#pragma once

#include <memory>

#include "engine/session/rank.h"
#include "engine/state/population.h"
#include "engine/state/script.h"

namespace motes::engine {

/// Particles of this rank as a script reads them: the first `count` of a store. What it writes into one that is not
/// `preview` counts; for one that is, see keep_preview.
struct ParticlesView {
  particles::Store* store;
  std::size_t count;
  bool preview;
};

/// Throws std::invalid_argument, the same on all ranks, where particles meet in what was recorded so far: nobody can
/// run that alone.
void check_readable(const System& system);

/// Returns what the last read showed, or the particles as they are.
ParticlesView seen(Population& here);

/// Runs what was recorded so far for a system that check_readable() accepts, on this rank alone, without communication:
/// each calculator creates the newborn particles of its own domain. The rest of the list runs at the frame's end. With
/// sub-steps a list may not run in parts, so it runs on a copy that is dropped at the frame's end.
ParticlesView read(Rank& rank, Script& script, Calculator& calculator, int system);

/// After a read in which all ranks take part: where this one failed before or within it, its list goes on like those of
/// the others, so that all hear of the failure and not of different lists.
void pass_over(const Rank& rank, System& system);

/// The script writes into such a copy, on all ranks: from here on it is what there is. All sub-steps of the list so far
/// have run then, before any of the rest. Views of the copy stay as they are. Where this rank fails, its list goes on
/// like those of the others.
void keep_preview(Rank& rank, Script& script, Calculator& calculator, int system);

/// Marks *_b attributes as in use, because the next read names them; they stay in use when the list runs again without
/// the script.
void read_copies(System& system, Population& here);

/// Collective, after read(): a fingerprint of what is seen is part of the next report.
void note_digest(const Rank& rank, const ParticlesView& seen, Population& here);

/// Collective, within a conversation of verb gather: all particles on rank 0, or on every rank; null elsewhere. Each
/// particle is sent once to a rank 0, and along a ring of all ranks where all want it. Not sorted.
std::unique_ptr<particles::Store> gather(Rank& rank, const System& system, const ParticlesView& seen, bool to_all);

}  // namespace motes::engine
