// The surface of a system's particles, from sums over all ranks (surfaces/field.h).
#pragma once

#include "engine/act/read.h"
#include "engine/session/rank.h"
#include "surfaces/field.h"
#include "surfaces/skin.h"

namespace motes::engine {

/// Returns the field of this rank's particles.
surfaces::Field field_of(Rank& rank, const ParticlesView& seen, const surfaces::Measure& measure);

/// Adds up the fields of all ranks, and returns the surface on every rank; if this rank has failed, an empty one.
/// Throws std::invalid_argument, on all ranks, if the field is too large. Collective, after all ranks have agreed that
/// none failed; they must agree again before the result is used.
surfaces::Skin surface_of_all(Rank& rank, surfaces::Field own);

}  // namespace motes::engine
