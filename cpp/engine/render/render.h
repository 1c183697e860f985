// render (paper 3.2.4): calculators project their particles and send the visible ones to the ranks that draw them (see
// render_plan.h); the image generator gets the whole picture.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "engine/render/render_plan.h"
#include "engine/render/shared_pictures.h"
#include "engine/session/rank.h"
#include "engine/session/report.h"
#include "engine/state/population.h"
#include "engine/state/script.h"
#include "image/light/shadow_grid.h"
#include "image/pixels.h"
#include "image/post/bloom.h"
#include "image/post/bloom_tiles.h"
#include "image/post/canvas.h"
#include "image/post/picture_light.h"
#include "image/post/tile_worker.h"
#include "image/project/projector.h"
#include "image/project/records.h"

namespace motes::engine {

/// The working memory for projecting and drawing, reused from frame to frame, and the last picture.
struct Painter {
  RenderPlan plan;     // plan of this frame's picture, from the manager
  image::Slots slots;  // the plan's order of tiles
  std::optional<image::Sprite::Blend> merged;  // path composite: the blend that is sent as partial tiles
  std::deque<image::Projector> projectors;  // one per thread
  std::vector<image::Records> records;  // records of this rank's particles, one or more batches per system
  std::vector<std::uint32_t> counts;    // number of these records by slot
  std::vector<std::uint64_t> pictures;  // one per system: number of pictures so far while it had particles
  std::unique_ptr<image::ShadowGrids> shadows;  // shadows of particles; null: they cast none
  image::Canvas canvas;                 // path gather: the whole picture
  image::PreparedScene scene;           // paths tiles, composite: the scene for this rank's tiles
  image::Pieces pieces;
  image::TileWorkers workers;
  image::Pixels pixels;
  SharedPictures shared;  // paths tiles, composite: memory shared between ranks of one host
  image::PictureLight whole;  // paths tiles, composite: the picture's light, if the view keeps it
  bool light_kept = false;
  image::BloomTiles bloom_tiles;  // paths tiles, composite: bloom of this rank's tiles
  image::Bloom bloom;             // bloom of the whole picture, on the image generator
  std::vector<std::vector<std::uint64_t>> glow;  // glow around this rank's tiles; unused on the image generator
  image::Layers layers;
  Drawing drawing;  // this rank's work on this frame's picture

  /// Paths tiles and composite: returns the pixels of a slot's tile.
  image::Area area(int slot) const { return scene.grid().area(slots.tile(slot)); }

  /// Image generator: moves out the last frame's picture, height * width * 3 bytes of sRGB.
  image::Pixels take_pixels() { return std::move(pixels); }
  /// Returns the picture's linear RGB light, height * width * 3 values. Throws std::logic_error if the view does not
  /// keep it.
  std::vector<float> linear() const;
  /// Returns one of the view's layers. Throws std::logic_error if the view does not ask for it.
  const std::vector<float>& layer(std::uint8_t bit) const;
};

/// Draws the frame's picture if its record has a view.
void render(Rank& rank, const Script& script, const Calculator& calculator, Painter& painter);

}  // namespace motes::engine
