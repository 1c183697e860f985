// render, paths tiles and composite, of a picture with bloom: ranks average their tiles' light, the image generator
// spreads these averages, and each rank adds the resulting glow to its tiles.
#pragma once

#include "base/bytes.h"
#include "engine/render/render.h"
#include "engine/session/rank.h"

namespace motes::engine {

/// Prepares the bloom of this rank's tiles.
void open_bloom(const Rank& rank, const image::View& view, Painter& painter);

/// Announces that this rank will receive messages with averages or glow.
void await_glow(Rank& rank, const Painter& painter);

/// Appends a tile's averages for the image generator. If the tile is not blank, the caller appends its layers next.
void put_averages(const Painter& painter, int tile, bool blank, base::Bytes& out);

/// Spreads the bloom: drawing ranks send averages of their tiles and get back the glow around each. Collective among
/// drawing ranks and the image generator.
void spread_glow(Rank& rank, const image::View& view, Painter& painter);

/// Adds glow to this rank's tiles, and shows them or sends them to the image generator.
void show_tiles(Rank& rank, const image::View& view, Painter& painter);

}  // namespace motes::engine
