// render, paths tiles and composite, of a picture with bloom: ranks average their tiles' light, the image generator
// spreads what all of them have told, and each rank shows its tiles with the glow of all.
#pragma once

#include "base/bytes.h"
#include "engine/render/render.h"
#include "engine/session/rank.h"

namespace motes::engine {

/// Makes room for the tiles of this rank.
void open_bloom(const Rank& rank, const image::View& view, Painter& painter);

/// Announces the messages with averages and glow, on drawing ranks and the image generator.
void await_glow(Rank& rank, const Painter& painter);

/// Writes what the image generator needs of a tile of this rank; the layers of one that is not blank follow.
void put_averages(const Painter& painter, int tile, bool blank, base::Bytes& out);

/// Spreads the bloom: drawing ranks send averages of their tiles and get back the glow around each. Collective among
/// drawing ranks and the image generator.
void spread_glow(Rank& rank, const image::View& view, Painter& painter);

/// Shows this rank's tiles, and sends them to the image generator where it is another one.
void show_tiles(Rank& rank, const image::View& view, Painter& painter);

}  // namespace motes::engine
