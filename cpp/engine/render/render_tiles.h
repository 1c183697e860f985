// render, paths tiles and composite: ranks draw their tiles of the picture, and the image generator assembles them.
#pragma once

#include "engine/render/render.h"
#include "engine/session/rank.h"

namespace motes::engine {

/// Image generator: announces that it will receive the tiles of other ranks.
void await_tiles(Rank& rank, const image::View& view, const Painter& painter);

/// Receives the records of this rank's tiles, draws the tiles and sends them to the image generator.
void draw_tiles(Rank& rank, const image::View& view, Painter& painter);

/// Image generator: receives the tiles of all ranks and assembles the picture.
void assemble(Rank& rank, const image::View& view, Painter& painter);

}  // namespace motes::engine
