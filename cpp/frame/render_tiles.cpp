#include "frame/render_tiles.h"

#include <algorithm>
#include <atomic>
#include <cstring>
#include <optional>
#include <stdexcept>
#include <string>

#include "frame/draw_work.h"
#include "frame/render_composite.h"
#include "frame/render_project.h"
#include "frame/render_slots.h"
#include "particles/memory.h"

namespace motes::frame {
namespace {

using image::Area;

// What is sent of a tile. Where the picture is shown as a whole these are sums of light, else sRGB.
enum class Content : std::uint8_t {
  one_color,
  pixels,
  drawn_one_color,  // nothing: they stand in memory that both ranks share
  drawn_pixels
};

std::size_t lanes(const Area& area) {
  return 3 * static_cast<std::size_t>(area.width) * static_cast<std::size_t>(area.height);
}

std::size_t first_pixel(const Area& area, std::size_t row) {
  return static_cast<std::size_t>(area.y) * row + 3 * static_cast<std::size_t>(area.x);
}

// Tiles that travel in one message.
struct Parcel {
  int first, end;  // slots
};

// A rank's tiles, in the order in which it draws and sends them: while it draws those of the next message, the image
// generator can take the last one. What has fewer than 2 * kBytes goes in one message, larger parts of a picture in
// several of kBytes or more, less what blank tiles save. All ranks find the same.
std::vector<Parcel> parcels_of(const RenderPlan& plan, int rank, const image::View& view) {
  constexpr double kBytes = 1 << 19;
  const int first = plan.first(rank), tiles = plan.end(rank) - first;
  const double pixel = image::PictureLight::needed(view, view.linear) ? sizeof(std::uint32_t) : sizeof(std::uint8_t);
  const double bytes = 3 * pixel * view.width * view.height * tiles / image::Grid{view.width, view.height}.tiles();
  const int parcels = std::clamp(static_cast<int>(bytes / kBytes), 1, std::max(1, tiles));
  std::vector<Parcel> all;
  for (int i = 0; i < parcels; ++i) all.push_back({first + tiles * i / parcels, first + tiles * (i + 1) / parcels});
  return all;
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
        end_(painter.plan.end(rank.talk.rank())), whole_(image::PictureLight::needed(view, view.linear)),
        shared_(rank.talk.draws() ? nullptr : painter.shared.find(rank.talk.stamp())) {}

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
    charge(end_ - first_);
  }

  void draw_into(const Parcel& parcel, particles::Bytes& out) {
    put_slots(*rank_.pool, parcel.first, parcel.end, out,
              [&](int slot, std::size_t worker, particles::Bytes& bytes) { put(slot, worker, bytes); });
    charge(parcel.end - parcel.first);
  }

 private:
  Area area_of(int slot) const { return painter_.scene.grid().area(painter_.slots.tile(slot)); }

  // Draws a tile into shared memory or a message.
  void put(int slot, std::size_t worker, particles::Bytes& out) {
    image::TileWorker& by = painter_.workers[worker];
    const Area area = area_of(slot);
    const bool blank = paint(slot, worker, by);
    if (shared_ != nullptr) {
      out.put(blank ? Content::drawn_one_color : Content::drawn_pixels);
      draw_shared(by, area);
    } else {
      out.put(blank ? Content::one_color : Content::pixels);
      put_pixels(by, area, blank, out);
    }
    if (whole_ && !blank) image::Layers::send(view_, by.painter, by.pieces, area, out);
  }

  void draw_shared(image::TileWorker& by, const Area& area) const {
    const std::size_t row = 3 * static_cast<std::size_t>(view_.width);
    if (whole_) {
      by.painter.sums(reinterpret_cast<std::uint32_t*>(shared_) + first_pixel(area, row), row);
    } else {
      by.painter.show(shared_ + first_pixel(area, row), row);
    }
  }

  void put_pixels(image::TileWorker& by, const Area& area, bool blank, particles::Bytes& out) const {
    const std::size_t row = 3 * static_cast<std::size_t>(area.width);
    if (whole_) {
      std::vector<std::uint32_t> sums(lanes(area));
      by.painter.sums(sums.data(), row);
      out.put_raw(sums.data(), (blank ? 3 : sums.size()) * sizeof(std::uint32_t));
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

  void charge(int tiles) {
    rank_.machine.charge(rank_.machine.costs().draw * static_cast<double>(drawn_.exchange(0)));
    const int passes = tiles + added_.exchange(0);  // over the pixels of a tile
    rank_.machine.charge_once(rank_.machine.costs().picture * passes / painter_.scene.grid().tiles());
  }

  Rank& rank_;
  const image::View& view_;
  Painter& painter_;
  int first_, end_;
  bool whole_;
  std::uint8_t* shared_;  // the whole picture, in memory of the image generator's; null: tiles travel
  std::vector<Partials> partials_;
  std::atomic<std::uint64_t> drawn_{0};  // records that are not charged yet
  std::atomic<int> added_{0};            // partial tiles, likewise
};

// Puts one tile of a message into the picture.
void place(particles::Reader& in, const Area& area, const image::View& view, bool shared, Painter& painter) {
  const std::size_t row = 3 * static_cast<std::size_t>(area.width);
  const std::size_t picture_row = 3 * static_cast<std::size_t>(view.width);
  const auto content = in.get<Content>();
  const Content last = shared ? Content::drawn_pixels : Content::pixels;
  if (content > last) {
    throw std::runtime_error("a tile's content must be 0.." + std::to_string(static_cast<int>(last)) + ", got " +
                             std::to_string(static_cast<int>(content)));
  }
  const bool blank = content == Content::one_color || content == Content::drawn_one_color;
  const bool drawn = content >= Content::drawn_one_color;
  const auto put = [&]<class T>(T* to) {
    const auto bytes = in.take((blank ? 3 : lanes(area)) * sizeof(T));
    constexpr int kAhead = 8;  // rows
    for (int y = 0; y < area.height; ++y, to += picture_row) {
      if (y + kAhead < area.height) particles::prefetch_for_write(to + kAhead * picture_row, row * sizeof(T));
      for (int x = 0; blank && x < area.width; ++x) std::memcpy(to + 3 * x, bytes.data(), bytes.size());
      if (!blank) std::memcpy(to, bytes.data() + static_cast<std::size_t>(y) * row * sizeof(T), row * sizeof(T));
    }
  };
  if (image::PictureLight::needed(view, view.linear)) {
    if (!drawn) put(painter.whole.at(area));
    blank ? painter.layers.keep_blank(area) : painter.layers.take(area, in);
  } else if (!drawn) {
    put(painter.pixels.data() + first_pixel(area, picture_row));
  }
}

void send_tiles(Rank& rank, comm::Message message, bool failed, Painter& painter) {
  Conversation& talk = rank.talk;
  painter.drawing.bytes += message.payload().size();
  talk.comm().post(talk.cast().image_generator, comm::Phase::tiles, talk.stamp(), std::move(message), 0, failed);
}

// Another rank has failed: its message goes on to the image generator in place of tiles.
void pass_on(Rank& rank, const comm::Message& message, Painter& painter) {
  const Conversation& talk = rank.talk;
  if (!talk.draws()) {
    comm::Message out;
    if (talk.failed()) {
      out = failure_message(talk.rank(), talk.failure());
    } else {
      out.bytes().put_raw(message.payload().data(), message.payload().size());
    }
    send_tiles(rank, std::move(out), true, painter);
  }
  if (!talk.failed()) give_up_for(rank, message);
}

// Waits for one message of another rank's tiles, and puts them into the picture.
void take_parcel(Rank& rank, const image::View& view, int from, const Parcel& parcel, Painter& painter) {
  Conversation& talk = rank.talk;
  comm::Message message = [&] {
    const Stopwatch::Phase phase(rank.watch, &PhaseTimes::render, "wait for tiles");
    return talk.comm().expect(from, comm::Phase::tiles, talk.stamp());
  }();
  if (message.header().failed != 0) return give_up_for(rank, message);
  const Stopwatch::Phase phase(rank.watch, &PhaseTimes::assemble, "assemble");
  const double start = rank.machine.compute_seconds();
  draw_work(rank, view, [&] {
    particles::Reader in = message.reader();
    const bool shared = painter.shared.opened(talk.stamp());
    for (int slot = parcel.first; slot < parcel.end; ++slot) {
      place(in, painter.scene.grid().area(painter.slots.tile(slot)), view, shared, painter);
    }
    if (!in.done()) throw std::runtime_error("a message has more tiles than its sender owns");
  });
  talk.comm().reuse(std::move(message));
  painter.drawing.assemble_s += rank.machine.compute_seconds() - start;
}

}  // namespace

void await_tiles(Rank& rank, const image::View& view, const Painter& painter) {
  for (int from = 0; from < rank.talk.size(); ++from) {
    if (!painter.plan.draws(from)) continue;
    const std::size_t parcels = parcels_of(painter.plan, from, view).size();
    rank.talk.comm().await(from, comm::Phase::tiles, static_cast<int>(parcels));
  }
}

void draw_tiles(Rank& rank, const image::View& view, Painter& painter) {
  Conversation& talk = rank.talk;
  if (!painter.plan.draws(talk.rank())) return;
  const std::vector<comm::Message> messages = receive_records(rank);
  if (!messages.empty() && messages.back().header().failed != 0) return pass_on(rank, messages.back(), painter);
  std::optional<TilesOfRank> tiles;
  // Returns whether it has not failed.
  const auto draw = [&](const auto& some) {
    const Stopwatch::Phase phase(rank.watch, &PhaseTimes::draw, "draw");
    const double start = rank.machine.compute_seconds();
    draw_work(rank, view, [&] {
      if (!tiles) tiles.emplace(rank, view, painter).take(messages);
      some();
    });
    rank.machine.slow_down(start);
    // On path composite tiles are drawn before they are sent: what is left for their owners tells no speed.
    if (painter.plan.path == image::View::Path::tiles) {
      painter.drawing.draw_s += rank.machine.compute_seconds() - start;
    }
    return !talk.failed();
  };
  if (talk.draws()) {
    draw([&] { tiles->draw_here(); });
    return;
  }
  for (const Parcel& parcel : parcels_of(painter.plan, talk.rank(), view)) {
    comm::Message out;
    if (!draw([&] { tiles->draw_into(parcel, out.bytes()); })) out = failure_message(talk.rank(), talk.failure());
    send_tiles(rank, std::move(out), talk.failed(), painter);
    if (talk.failed()) return;
  }
}

void assemble(Rank& rank, const image::View& view, Painter& painter) {
  Conversation& talk = rank.talk;
  for (int from = 0; from < talk.size() && !talk.failed(); ++from) {
    if (from == talk.rank() || !painter.plan.draws(from)) continue;
    const std::vector<Parcel> parcels = parcels_of(painter.plan, from, view);
    for (std::size_t i = 0; i < parcels.size() && !talk.failed(); ++i) {
      if (i > 0) talk.comm().await(from, comm::Phase::tiles, static_cast<int>(parcels.size() - i));
      take_parcel(rank, view, from, parcels[i], painter);
    }
  }
  if (talk.failed() || !image::PictureLight::needed(view, view.linear)) return;
  const Stopwatch::Phase phase(rank.watch, &PhaseTimes::assemble, "spread and show light");
  const double start = rank.machine.compute_seconds();
  draw_work(rank, view, [&] { painter.whole.finish(painter.scene, painter.pixels, *rank.pool); });
  painter.drawing.assemble_s += rank.machine.compute_seconds() - start;
}

}  // namespace motes::frame
