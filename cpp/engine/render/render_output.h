// render, paths tiles and composite: writes drawn tiles to the image generator's picture, directly, through shared
// memory or in messages.
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

/// The tiles of one message.
struct Parcel {
  int first, end;  // slots
};

/// Returns a rank's tiles by message, in the order of drawing: the image generator can read a message while the rank
/// draws the next one's tiles. The same on all ranks.
std::vector<Parcel> parcels_of(const RenderPlan& plan, int rank, const image::View& view);

/// Writes tiles as sRGB, or as sums of light if the picture's light is kept. Threads may write different tiles
/// concurrently.
class TileOutput {
 public:
  TileOutput(const Rank& rank, const image::View& view, Painter& painter);

  /// Image generator: writes a tile into the picture.
  void show(const image::TilePainter& by, const image::TileLight& light, int slot) const;

  /// Other ranks: writes a tile into shared memory or a message. `blank`: all pixels are equal.
  void put(const image::TilePainter& by, const image::TileLight& light, int slot, bool blank, base::Bytes& out) const;

 private:
  void put_pixels(const image::TilePainter& by, const image::TileLight& light, bool blank, base::Bytes& out) const;
  std::size_t at(int slot) const;

  const image::View& view_;
  Painter& painter_;
  std::uint8_t* shared_;  // the picture in memory shared with the image generator; null: send tiles in messages
};

/// Image generator: reads a tile that put() wrote. Returns whether it is blank. `shared`: other ranks may have drawn
/// into shared memory. Throws std::runtime_error if the bytes are malformed.
bool take_tile(base::Reader& in, int slot, const image::View& view, bool shared, Painter& painter);

/// Sends a message with tiles or their averages to the image generator.
void send_to_image_generator(Rank& rank, comm::Phase phase, comm::Message message, bool failed, Painter& painter);

/// Runs `draw` and counts its time as drawing. Returns false if this rank has failed.
template <class Work>
bool draw_some(Rank& rank, const image::View& view, Painter& painter, const Work& draw) {
  const Stopwatch::Phase phase(rank.watch, &PhaseTimes::draw, "draw");
  const double start = rank.machine.compute_seconds();
  draw_work(rank, view, draw);
  rank.machine.slow_down(start);
  // On path composite owners mostly merge tiles, which does not measure their drawing speed.
  if (painter.plan.path == image::View::Path::tiles) {
    painter.drawing.draw_s += rank.machine.compute_seconds() - start;
  }
  return !rank.session.failed();
}

/// Calls draw(bytes) to fill a message and sends it to the image generator; if that fails, sends the failure.
template <class Work>
bool draw_and_send(Rank& rank, const image::View& view, Painter& painter, comm::Phase phase, const Work& draw) {
  comm::Message out;
  const bool drawn = draw_some(rank, view, painter, [&] { draw(out.bytes()); });
  if (!drawn) out = failure_message(rank.session.rank(), rank.session.failure());
  send_to_image_generator(rank, phase, std::move(out), !drawn, painter);
  return drawn;
}

}  // namespace motes::engine
