// Frames from recorded lists instead of a script.
#pragma once

#include "engine/engine.h"

namespace motes::engine {

/// Records what the list says, up to its end, without running the frame: systems that are new, births, actions.
/// Throws std::runtime_error where the list needs the script itself (callbacks) or does not fit the engine's systems.
void record_again(Engine& engine, const recording::Record& list);

/// Collective. One frame of a scene; with a picture where the script rendered one and `picture` says so. Throws
/// std::runtime_error where it is not the engine's next frame.
void replay(Engine& engine, const recording::Record& list, bool picture);

}  // namespace motes::engine
