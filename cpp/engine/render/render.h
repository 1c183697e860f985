// render (paper 3.2.4): calculators project their particles and send what is visible to the ranks that draw it; the
// image generator has the whole picture in the end. render_plan.h says who draws what.
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

/// The painter: working memory for projecting and drawing, reused from frame to frame, and the last picture.
struct Painter {
  RenderPlan plan;     // plan of this frame's picture, from the manager
  image::Slots slots;  // the plan's order of tiles
  std::optional<image::Sprite::Blend> merged;  // path composite: of what is sent as partial tiles
  std::deque<image::Projector> projectors;  // one per thread
  std::vector<image::Records> records;  // records of this rank's particles, one or more batches per system
  std::vector<std::uint32_t> counts;    // number of these records by slot
  std::vector<std::uint64_t> pictures;  // so far, in which there were particles of a system: one per system
  std::unique_ptr<image::ShadowGrids> shadows;  // of particles; null: they throw none
  image::Canvas canvas;                 // path gather: all of the picture
  image::PreparedScene scene;           // paths tiles, composite: the scene as far as this rank's tiles need it
  image::Pieces pieces;
  image::TileWorkers workers;
  image::Pixels pixels;
  SharedPictures shared;  // paths tiles, composite: memory shared with ranks of one host
  image::PictureLight whole;  // paths tiles, composite: the picture's light, if the view keeps it
  bool light_kept = false;
  image::BloomTiles bloom_tiles;  // paths tiles, composite: bloom of this rank's tiles
  image::Bloom bloom;             // bloom of the whole picture, on the image generator
  std::vector<std::vector<std::uint64_t>> glow;  // around this rank's tiles, where it is another one
  image::Layers layers;
  Drawing drawing;  // what this rank did for this frame's picture

  /// Paths tiles and composite: the pixels of a slot's tile.
  image::Area area(int slot) const { return scene.grid().area(slots.tile(slot)); }

  /// The picture of the last frame, on the image generator: height * width * 3 bytes of sRGB, moved out.
  image::Pixels take_pixels() { return std::move(pixels); }
  /// Returns the picture's linear RGB light, height * width * 3. Throws std::logic_error if the view does not keep it.
  std::vector<float> linear() const;
  /// Returns one of the view's layers. Throws std::logic_error if the view does not ask for it.
  const std::vector<float>& layer(std::uint8_t bit) const;
};

/// Draws the frame where its record has a view.
void render(Rank& rank, const Script& script, const Calculator& calculator, Painter& painter);

}  // namespace motes::engine
