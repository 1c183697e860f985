// render, paths tiles and composite: where the light of drawn tiles goes, into the image generator's picture in the
// end.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "base/bytes.h"
#include "comm/message.h"
#include "engine/render/draw_work.h"
#include "engine/render/render.h"
#include "engine/render/render_project.h"
#include "engine/session/rank.h"
#include "image/tile_light.h"

namespace motes::engine {

/// Tiles that travel in one message.
struct Parcel {
  int first, end;  // slots
};

/// Returns a rank's tiles by message, in the order of drawing: while it draws the next message's tiles, the image
/// generator can take the last one. All ranks get the same result.
std::vector<Parcel> parcels_of(const RenderPlan& plan, int rank, const image::View& view);

/// Shows tiles: sRGB, or sums of light where the picture's light is kept. Several threads may show different tiles.
class TileOutput {
 public:
  TileOutput(const Rank& rank, const image::View& view, Painter& painter);

  /// Writes a tile into the picture, on the image generator.
  void show(const image::TilePainter& by, const image::TileLight& light, int slot) const;

  /// Writes a tile into shared memory or a message, on other ranks. `blank`: all pixels are alike.
  void put(const image::TilePainter& by, const image::TileLight& light, int slot, bool blank, base::Bytes& out) const;

 private:
  void put_pixels(const image::TilePainter& by, const image::TileLight& light, bool blank, base::Bytes& out) const;
  std::size_t at(int slot) const;

  const image::View& view_;
  Painter& painter_;
  std::uint8_t* shared_;  // the whole picture, in memory of the image generator's; null: tiles travel
};

/// The image generator: takes what put() wrote of a tile. Returns whether it is blank. `shared`: others may have found
/// the picture's memory. Throws std::runtime_error where the bytes are malformed.
bool take_tile(base::Reader& in, int slot, const image::View& view, bool shared, Painter& painter);

/// Sends a message of tiles, or of what is known of them, to the image generator.
void send_to_image_generator(Rank& rank, comm::Phase phase, comm::Message message, bool failed, Painter& painter);

/// Draws some tiles; the seconds count as those of drawing. Returns whether this rank has not failed.
template <class Work>
bool draw_some(Rank& rank, const image::View& view, Painter& painter, const Work& draw) {
  const Stopwatch::Phase phase(rank.watch, &PhaseTimes::draw, "draw");
  const double start = rank.machine.compute_seconds();
  draw_work(rank, view, draw);
  rank.machine.slow_down(start);
  // On path composite owners only merge tiles, which tells nothing about their speed.
  if (painter.plan.path == image::View::Path::tiles) {
    painter.drawing.draw_s += rank.machine.compute_seconds() - start;
  }
  return !rank.session.failed();
}

/// Calls draw(bytes) to fill a message for the image generator; if that fails, the message says why.
template <class Work>
bool draw_and_send(Rank& rank, const image::View& view, Painter& painter, comm::Phase phase, const Work& draw) {
  comm::Message out;
  const bool drawn = draw_some(rank, view, painter, [&] { draw(out.bytes()); });
  if (!drawn) out = failure_message(rank.session.rank(), rank.session.failure());
  send_to_image_generator(rank, phase, std::move(out), !drawn, painter);
  return drawn;
}

}  // namespace motes::engine
