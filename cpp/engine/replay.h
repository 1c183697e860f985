// Runs frames from recorded lists instead of a script.
#pragma once

#include "engine/engine.h"

namespace motes::engine {

/// Records the items of a list, and defines its new systems, without running the frame. Throws std::runtime_error if
/// the list needs the script (callbacks) or does not match the engine's systems.
void record_again(Engine& engine, const recording::Record& list);

/// Runs one frame of a scene, with a picture if `picture` is set and the script rendered one. Throws std::runtime_error
/// if it is not the engine's next frame. Collective.
void replay(Engine& engine, const recording::Record& list, bool picture);

}  // namespace motes::engine
