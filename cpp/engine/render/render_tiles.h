// render, paths tiles and composite: ranks draw their tiles of the picture; the image generator puts them together.
#pragma once

#include "engine/render/render.h"
#include "engine/session/rank.h"

namespace motes::engine {

/// Image generator: the tiles of other ranks may arrive from now on.
void await_tiles(Rank& rank, const image::View& view, const Painter& painter);

/// Receives the records of this rank's tiles, draws them and sends them to the image generator.
void draw_tiles(Rank& rank, const image::View& view, Painter& painter);

/// Image generator: puts the tiles of all ranks together.
void assemble(Rank& rank, const image::View& view, Painter& painter);

}  // namespace motes::engine
