#include "engine/render/render_tiles.h"

#include <atomic>
#include <optional>
#include <stdexcept>
#include <vector>

#include "engine/render/render_bloom.h"
#include "engine/render/render_composite.h"
#include "engine/render/render_costs.h"
#include "engine/render/render_output.h"
#include "engine/render/render_project.h"
#include "engine/render/render_slots.h"

namespace motes::engine {
namespace {

using image::Area;

// Receives calculators' records for this rank's tiles.
std::vector<comm::Message> receive_records(Rank& rank) {
  const Stopwatch::Phase phase(rank.watch, &PhaseTimes::render, "wait for records");
  std::vector<comm::Message> messages;
  for (const int from : rank.session.cast().calculators) {
    if (from == rank.session.rank()) continue;
    messages.push_back(rank.session.comm().expect(from, comm::Phase::records, rank.session.stamp()));
    if (messages.back().header().failed != 0) break;  // the other messages do not matter then
  }
  return messages;
}

class TilesOfRank {
 public:
  TilesOfRank(Rank& rank, const image::View& view, Painter& painter)
      : rank_(rank), view_(view), painter_(painter), first_(painter.plan.first(rank.session.rank())),
        end_(painter.plan.end(rank.session.rank())), output_(rank, view, painter) {}

  void take(const std::vector<comm::Message>& messages) {
    double received = 0;
    for (const comm::Message& message : messages) {
      received += static_cast<double>(message.header().count);
      base::Reader in = message.reader();
      take_records(in, [&](std::span<const std::byte> records) { painter_.pieces.add(records); });
      partials_.emplace_back(in, painter_, first_, end_);
    }
    rank_.machine.charge(rank_.machine.costs().collect * received);
    painter_.drawing.first = static_cast<std::uint32_t>(first_);
    painter_.drawing.counts.assign(static_cast<std::size_t>(end_ - first_), 0);
  }

  // Image generator: draws its tiles into the picture.
  void draw_here() {
    rank_.pool->run(static_cast<std::size_t>(end_ - first_), [&](std::size_t part, std::size_t worker) {
      const int slot = first_ + static_cast<int>(part);
      image::TileWorker& by = painter_.workers[worker];
      paint(slot, worker, by);
      if (view_.bloom > 0) {
        painter_.bloom_tiles.keep(part, by.painter.light(), worker);
      } else {
        output_.show(by.painter, by.painter.light(), slot);
      }
      painter_.layers.keep(by.painter, by.pieces, painter_.area(slot));
    });
    charge(end_ - first_);
  }

  void draw_into(const Parcel& parcel, base::Bytes& out) {
    put_slots(*rank_.pool, parcel.first, parcel.end, out,
              [&](int slot, std::size_t worker, base::Bytes& bytes) { put(slot, worker, bytes); });
    charge(parcel.end - parcel.first);
  }

 private:
  // Draws a tile and writes it into shared memory or a message; with bloom, writes its averages instead.
  void put(int slot, std::size_t worker, base::Bytes& out) {
    image::TileWorker& by = painter_.workers[worker];
    const bool blank = paint(slot, worker, by);
    if (view_.bloom > 0) {
      painter_.bloom_tiles.keep(static_cast<std::size_t>(slot - first_), by.painter.light(), worker);
      put_averages(painter_, slot - first_, blank, out);
    } else {
      output_.put(by.painter, by.painter.light(), slot, blank, out);
    }
    if (!blank) image::Layers::send(view_, by.painter, by.pieces, painter_.area(slot), out);
  }

  // Draws a tile; returns whether it is only background.
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
    const image::Scenery& scenery = painter_.scene.scenery();
    return records == 0 && !scenery.occupied(tile) && !scenery.blurs();
  }

  void charge(int tiles) {
    rank_.machine.charge(rank_.machine.costs().draw * static_cast<double>(drawn_.exchange(0)));
    const double passes = tiles * render_costs::passes(view_) + added_.exchange(0);  // passes over a tile's pixels
    rank_.machine.charge_once(rank_.machine.costs().picture * passes / painter_.scene.grid().tiles());
  }

  Rank& rank_;
  const image::View& view_;
  Painter& painter_;
  int first_, end_;
  TileOutput output_;
  std::vector<Partials> partials_;
  std::atomic<std::uint64_t> drawn_{0};  // records that are not charged yet
  std::atomic<int> added_{0};            // partial tiles that are not charged yet
};

// Gives up because another rank has failed, and forwards its message to the image generator in place of tiles.
void pass_on(Rank& rank, const comm::Message& message, const image::View& view, Painter& painter) {
  const Session& session = rank.session;
  if (!session.draws()) {
    comm::Message out;
    if (session.failed()) {
      out = failure_message(session.rank(), session.failure());
    } else {
      out.bytes().put_raw(message.payload().data(), message.payload().size());
    }
    const auto phase = view.bloom > 0 ? comm::Phase::glow : comm::Phase::tiles;
    send_to_image_generator(rank, phase, std::move(out), true, painter);
  }
  if (!session.failed()) give_up_for(rank, message);
}

// Waits for one message with another rank's tiles and copies them into the picture.
void take_parcel(Rank& rank, const image::View& view, int from, const Parcel& parcel, Painter& painter) {
  Session& session = rank.session;
  comm::Message message = [&] {
    const Stopwatch::Phase phase(rank.watch, &PhaseTimes::render, "wait for tiles");
    return session.comm().expect(from, comm::Phase::tiles, session.stamp());
  }();
  if (message.header().failed != 0) return give_up_for(rank, message);
  const Stopwatch::Phase phase(rank.watch, &PhaseTimes::assemble, "assemble");
  const double start = rank.machine.compute_seconds();
  draw_work(rank, view, [&] {
    base::Reader in = message.reader();
    const bool shared = painter.shared.opened(session.stamp());
    for (int slot = parcel.first; slot < parcel.end; ++slot) {
      const bool blank = take_tile(in, slot, view, shared, painter);
      if (view.bloom > 0) continue;  // layers arrived with the averages
      const Area area = painter.area(slot);
      blank ? painter.layers.keep_blank(area) : painter.layers.take(area, in);
    }
    if (!in.done()) throw std::runtime_error("a message has more tiles than its sender owns");
  });
  session.comm().reuse(std::move(message));
  painter.drawing.assemble_s += rank.machine.compute_seconds() - start;
}

}  // namespace

void await_tiles(Rank& rank, const image::View& view, const Painter& painter) {
  for (int from = 0; from < rank.session.size(); ++from) {
    if (!painter.plan.draws(from)) continue;
    const std::size_t parcels = parcels_of(painter.plan, from, view).size();
    rank.session.comm().await(from, comm::Phase::tiles, static_cast<int>(parcels));
  }
}

void draw_tiles(Rank& rank, const image::View& view, Painter& painter) {
  const Session& session = rank.session;
  if (!painter.plan.draws(session.rank())) return;
  const std::vector<comm::Message> messages = receive_records(rank);
  if (!messages.empty() && messages.back().header().failed != 0) return pass_on(rank, messages.back(), view, painter);
  std::optional<TilesOfRank> tiles;
  const auto opened = [&]() -> TilesOfRank& {
    if (!tiles) tiles.emplace(rank, view, painter).take(messages);
    return *tiles;
  };
  if (session.draws()) {
    draw_some(rank, view, painter, [&] { opened().draw_here(); });
    return;
  }
  const auto send = [&](const Parcel& parcel, comm::Phase phase) {
    return draw_and_send(rank, view, painter, phase, [&](base::Bytes& out) { opened().draw_into(parcel, out); });
  };
  if (view.bloom > 0) {
    send({painter.plan.first(session.rank()), painter.plan.end(session.rank())}, comm::Phase::glow);
    return;
  }
  for (const Parcel& parcel : parcels_of(painter.plan, session.rank(), view)) {
    if (!send(parcel, comm::Phase::tiles)) return;
  }
}

void assemble(Rank& rank, const image::View& view, Painter& painter) {
  Session& session = rank.session;
  for (int from = 0; from < session.size() && !session.failed(); ++from) {
    if (from == session.rank() || !painter.plan.draws(from)) continue;
    const std::vector<Parcel> parcels = parcels_of(painter.plan, from, view);
    for (std::size_t i = 0; i < parcels.size() && !session.failed(); ++i) {
      if (i > 0) session.comm().await(from, comm::Phase::tiles, static_cast<int>(parcels.size() - i));
      take_parcel(rank, view, from, parcels[i], painter);
    }
  }
  if (session.failed() || !view.linear) return;
  const Stopwatch::Phase phase(rank.watch, &PhaseTimes::assemble, "show light");
  const double start = rank.machine.compute_seconds();
  draw_work(rank, view, [&] { painter.whole.show(painter.scene, painter.pixels, *rank.pool); });
  painter.drawing.assemble_s += rank.machine.compute_seconds() - start;
}

}  // namespace motes::engine
