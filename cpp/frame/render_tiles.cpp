#include "frame/render_tiles.h"

#include <atomic>
#include <cstring>

#include "frame/render_composite.h"
#include "frame/render_project.h"
#include "frame/render_slots.h"

namespace motes::frame {
namespace {

using image::Area;

// How a tile is sent: one colour, or all of its pixels. Where the picture is shown as a whole these are sums of light,
// else sRGB.
enum class Content : std::uint8_t { one_color, pixels };

std::size_t lanes(const Area& area) {
  return 3 * static_cast<std::size_t>(area.width) * static_cast<std::size_t>(area.height);
}

std::size_t first_pixel(const Area& area, std::size_t row) {
  return static_cast<std::size_t>(area.y) * row + 3 * static_cast<std::size_t>(area.x);
}

// What calculators have sent for this rank's tiles.
std::vector<comm::Message> receive_records(Rank& rank) {
  const Stopwatch::Phase phase(rank.watch, &PhaseTimes::render, "wait for records");
  std::vector<comm::Message> messages;
  for (const int from : rank.talk.cast().calculators) {
    if (from == rank.talk.rank()) continue;
    messages.push_back(rank.talk.comm().expect(from, comm::Phase::records, rank.talk.stamp()));
    if (messages.back().header().failed != 0) break;  // nothing else matters
  }
  return messages;
}

class TilesOfRank {
 public:
  TilesOfRank(Rank& rank, const image::View& view, Painter& painter)
      : rank_(rank), view_(view), painter_(painter), first_(painter.plan.first(rank.talk.rank())),
        end_(painter.plan.end(rank.talk.rank())), whole_(image::PictureLight::needed(view, view.linear)) {}

  void take(const std::vector<comm::Message>& messages) {
    double received = 0;
    for (const comm::Message& message : messages) {
      received += static_cast<double>(message.header().count);
      particles::Reader in = message.reader();
      take_records(in, [&](std::span<const std::byte> records) { painter_.pieces.add(records); });
      partials_.emplace_back(in, painter_, first_, end_);
    }
    rank_.machine.charge(rank_.machine.costs().collect * received);
    painter_.drawing.first = static_cast<std::uint32_t>(first_);
    painter_.drawing.counts.assign(static_cast<std::size_t>(end_ - first_), 0);
  }

  // Draws into the picture itself.
  void draw_here() {
    const std::size_t row = 3 * static_cast<std::size_t>(view_.width);
    rank_.pool->run(static_cast<std::size_t>(end_ - first_), [&](std::size_t part, std::size_t worker) {
      const int slot = first_ + static_cast<int>(part);
      image::TileWorker& by = painter_.workers[worker];
      const Area area = area_of(slot);
      paint(slot, worker, by);
      if (whole_) {
        by.painter.sums(painter_.whole.at(area), row);
        painter_.layers.keep(by.painter, by.pieces, area);
      } else {
        by.painter.show(painter_.pixels.data() + first_pixel(area, row), row);
      }
    });
    finish();
  }

  void draw_into(particles::Bytes& out) {
    put_slots(*rank_.pool, first_, end_, out,
              [&](int slot, std::size_t worker, particles::Bytes& bytes) { put(slot, worker, bytes); });
    finish();
  }

 private:
  Area area_of(int slot) const { return painter_.scene.grid().area(painter_.slots.tile(slot)); }

  // Draws a tile into a message.
  void put(int slot, std::size_t worker, particles::Bytes& out) {
    image::TileWorker& by = painter_.workers[worker];
    const Area area = area_of(slot);
    const bool blank = paint(slot, worker, by);
    out.put(static_cast<std::uint8_t>(blank ? Content::one_color : Content::pixels));
    const std::size_t row = 3 * static_cast<std::size_t>(area.width);
    if (whole_) {
      std::vector<std::uint32_t> sums(lanes(area));
      by.painter.sums(sums.data(), row);
      out.put_raw(sums.data(), (blank ? 3 : sums.size()) * sizeof(std::uint32_t));
      if (!blank) image::Layers::send(view_, by.painter, by.pieces, area, out);
    } else if (blank) {
      std::vector<std::uint8_t> pixels(lanes(area));
      by.painter.show(pixels.data(), row);
      out.put_raw(pixels.data(), 3);
    } else {
      by.painter.show(reinterpret_cast<std::uint8_t*>(out.extend(lanes(area))), row);
    }
  }

  // Returns whether the tile is background and nothing else.
  bool paint(int slot, std::size_t worker, image::TileWorker& by) {
    const int tile = painter_.slots.tile(slot);
    std::uint64_t records = painter_.pieces.collect(tile, by.pieces);
    drawn_ += records;
    painter_.scene.render(tile, worker);
    by.painter.start(painter_.scene.grid().area(tile));
    for (const Partials& partials : partials_) {
      added_ += partials.has(slot) ? 1 : 0;
      records += partials.add_to(slot, by.painter);
    }
    by.painter.paint(by.pieces);
    painter_.drawing.counts[static_cast<std::size_t>(slot - first_)] = static_cast<std::uint32_t>(records);
    return records == 0 && !painter_.scene.scenery().occupied(tile);
  }

  void finish() {
    rank_.machine.charge(rank_.machine.costs().draw * static_cast<double>(drawn_));
    const int passes = end_ - first_ + added_;  // over the pixels of a tile
    rank_.machine.charge_once(rank_.machine.costs().picture * passes / painter_.scene.grid().tiles());
  }

  Rank& rank_;
  const image::View& view_;
  Painter& painter_;
  int first_, end_;
  bool whole_;
  std::vector<Partials> partials_;
  std::atomic<std::uint64_t> drawn_{0};  // records
  std::atomic<int> added_{0};            // partial tiles
};

// Puts one tile of a message into the picture.
void place(particles::Reader& in, const Area& area, const image::View& view, Painter& painter) {
  const std::size_t row = 3 * static_cast<std::size_t>(area.width);
  const std::size_t picture_row = 3 * static_cast<std::size_t>(view.width);
  const auto content = in.get<std::uint8_t>();
  const bool blank = content == static_cast<std::uint8_t>(Content::one_color);
  const auto put = [&]<class T>(T* to) {
    const auto bytes = in.take((blank ? 3 : lanes(area)) * sizeof(T));
    for (int y = 0; y < area.height; ++y, to += picture_row) {
      for (int x = 0; blank && x < area.width; ++x) std::memcpy(to + 3 * x, bytes.data(), bytes.size());
      if (!blank) std::memcpy(to, bytes.data() + static_cast<std::size_t>(y) * row * sizeof(T), row * sizeof(T));
    }
  };
  if (image::PictureLight::needed(view, view.linear)) {
    put(painter.whole.at(area));
    blank ? painter.layers.keep_blank(area) : painter.layers.take(area, in);
  } else {
    put(painter.pixels.data() + first_pixel(area, picture_row));
  }
}

}  // namespace

void draw_tiles(Rank& rank, const image::View& view, Painter& painter) {
  Conversation& talk = rank.talk;
  if (!painter.plan.draws(talk.rank())) return;
  const std::vector<comm::Message> messages = receive_records(rank);
  const bool told = !messages.empty() && messages.back().header().failed != 0;
  comm::Message out;
  {
    const Stopwatch::Phase phase(rank.watch, &PhaseTimes::draw, "draw");
    const double start = rank.machine.compute_seconds();
    if (!told) {
      talk.work("render", [&] {
        TilesOfRank tiles(rank, view, painter);
        tiles.take(messages);
        if (talk.draws()) {
          tiles.draw_here();
        } else {
          tiles.draw_into(out.bytes());
        }
      });
    }
    rank.machine.slow_down(start);
    // On path composite tiles are drawn before they are sent: what is left for their owners tells no speed.
    if (painter.plan.path == image::View::Path::tiles) {
      painter.drawing.draw_s = rank.machine.compute_seconds() - start;
    }
  }
  if (!talk.draws()) {
    if (told && !talk.failed()) {
      out = comm::Message();
      out.bytes().put_raw(messages.back().payload().data(), messages.back().payload().size());
    } else if (talk.failed()) {
      out = failure_message(talk.rank(), talk.failure());
    }
    painter.drawing.bytes += out.payload().size();
    talk.comm().post(talk.cast().image_generator, comm::Phase::tiles, talk.stamp(), std::move(out), 0,
                     told || talk.failed());
  }
  if (told && !talk.failed()) give_up_for(rank, messages.back());
}

void assemble(Rank& rank, const image::View& view, Painter& painter) {
  Conversation& talk = rank.talk;
  const image::Grid grid{view.width, view.height};
  for (int from = 0; from < talk.size() && !talk.failed(); ++from) {
    if (from == talk.rank() || !painter.plan.draws(from)) continue;
    const comm::Message message = [&] {
      const Stopwatch::Phase phase(rank.watch, &PhaseTimes::render, "wait for tiles");
      return talk.comm().expect(from, comm::Phase::tiles, talk.stamp());
    }();
    if (message.header().failed != 0) give_up_for(rank, message);
    const Stopwatch::Phase phase(rank.watch, &PhaseTimes::assemble, "assemble");
    talk.work("render", [&] {
      particles::Reader in = message.reader();
      for (int slot = painter.plan.first(from); slot < painter.plan.end(from); ++slot) {
        place(in, grid.area(painter.slots.tile(slot)), view, painter);
      }
      if (!in.done()) throw std::runtime_error("a message has more tiles than its sender owns");
    });
  }
  if (talk.failed() || !image::PictureLight::needed(view, view.linear)) return;
  const Stopwatch::Phase phase(rank.watch, &PhaseTimes::assemble, "spread and show light");
  talk.work("render", [&] { painter.whole.finish(painter.scene, painter.pixels, *rank.pool); });
}

}  // namespace motes::frame
