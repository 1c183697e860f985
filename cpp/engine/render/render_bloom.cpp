#include "engine/render/render_bloom.h"

#include <cstring>
#include <stdexcept>
#include <utility>
#include <vector>

#include "engine/render/draw_work.h"
#include "engine/render/render_costs.h"
#include "engine/render/render_output.h"
#include "engine/render/render_project.h"
#include "engine/render/render_slots.h"

namespace motes::engine {
namespace {

using image::CellArea;

// Calls work(rank) for each drawing rank except the image generator.
template <class Work>
void each_other(const Rank& rank, const Painter& painter, const Work& work) {
  for (int other = 0; other < rank.session.size(); ++other) {
    if (other != rank.session.cast().image_generator && painter.plan.draws(other)) work(other);
  }
}

// Adds the averages of another rank's tiles to the picture's cells, and reads their layers.
void take_averages(const comm::Message& message, int from, Painter& painter) {
  base::Reader in = message.reader();
  for (int slot = painter.plan.first(from); slot < painter.plan.end(from); ++slot) {
    const CellArea cells = painter.bloom_tiles.plan().cells(painter.area(slot));
    painter.bloom.add(cells, in.take(cells.lanes() * sizeof(std::uint64_t)));
    const bool blank = in.get<std::uint8_t>() != 0;
    blank ? painter.layers.keep_blank(painter.area(slot)) : painter.layers.take(painter.area(slot), in);
  }
  if (!in.done()) throw std::runtime_error("a message has more light than its sender's tiles");
}

// Appends the glow around each tile of a rank.
void put_glow(int to, const Painter& painter, base::Bytes& out) {
  const image::BloomCells all = painter.bloom.cells();
  std::vector<CellArea> tiles;
  std::size_t bytes = 0;
  for (int slot = painter.plan.first(to); slot < painter.plan.end(to); ++slot) {
    tiles.push_back(painter.bloom_tiles.plan().cells(painter.area(slot)));
    bytes += tiles.back().lanes() * sizeof(std::uint64_t);
  }
  out.reserve(bytes);
  for (const CellArea& cells : tiles) {
    for (int y = cells.y; y < cells.y + cells.height; ++y) {
      out.put_raw(all.row(y) + 3 * cells.x, cells.row_lanes() * sizeof(std::uint64_t));
    }
  }
}

void send_glow(Rank& rank, int to, comm::Message message, bool failed, Painter& painter) {
  painter.drawing.bytes += message.payload().size();
  rank.session.comm().post(to, comm::Phase::glow, rank.session.stamp(), std::move(message), 0, failed);
}

// Sends the failure of rank `failed` to the other drawing ranks, which wait for glow.
void tell_others(Rank& rank, int failed, const comm::Message& why, Painter& painter) {
  each_other(rank, painter, [&](int to) {
    if (to == failed) return;
    comm::Message message;
    message.bytes().put_raw(why.payload().data(), why.payload().size());
    send_glow(rank, to, std::move(message), true, painter);
  });
}

std::vector<comm::Message> receive_averages(Rank& rank, Painter& painter) {
  const Stopwatch::Phase phase(rank.watch, &PhaseTimes::render, "wait for light");
  std::vector<comm::Message> messages;
  each_other(rank, painter, [&](int from) {
    messages.push_back(rank.session.comm().expect(from, comm::Phase::glow, rank.session.stamp()));
    if (messages.back().header().failed == 0) return;
    tell_others(rank, from, messages.back(), painter);
    give_up_for(rank, messages.back());
  });
  return messages;
}

// Image generator: spreads the averages of all ranks and sends each rank the glow around its tiles.
void spread_all(Rank& rank, const image::View& view, Painter& painter) {
  Session& session = rank.session;
  std::vector<comm::Message> messages;
  if (!session.failed()) messages = receive_averages(rank, painter);
  const Stopwatch::Phase phase(rank.watch, &PhaseTimes::assemble, "spread light");
  draw_work(rank, view, [&] {
    painter.bloom.begin(painter.bloom_tiles.plan());
    painter.bloom.add(painter.bloom_tiles);
    std::size_t next = 0;
    each_other(rank, painter, [&](int from) { take_averages(messages[next++], from, painter); });
    painter.bloom.spread(*rank.pool);
    rank.machine.charge_once(rank.machine.costs().picture * render_costs::spreading(view));
  });
  each_other(rank, painter, [&](int to) {
    comm::Message message;
    draw_work(rank, view, [&] { put_glow(to, painter, message.bytes()); });
    if (session.failed()) message = failure_message(session.rank(), session.failure());
    send_glow(rank, to, std::move(message), session.failed(), painter);
  });
  for (comm::Message& message : messages) session.comm().reuse(std::move(message));
}

// Other drawing ranks: receives the glow around this rank's tiles.
void take_glow(Rank& rank, const image::View& view, Painter& painter) {
  Session& session = rank.session;
  comm::Message message = [&] {
    const Stopwatch::Phase phase(rank.watch, &PhaseTimes::render, "wait for glow");
    return session.comm().expect(session.cast().image_generator, comm::Phase::glow, session.stamp());
  }();
  if (message.header().failed != 0) give_up_for(rank, message);
  draw_work(rank, view, [&] {
    base::Reader in = message.reader();
    painter.glow.clear();
    for (std::size_t tile = 0; tile < painter.bloom_tiles.tiles(); ++tile) {
      const CellArea& cells = painter.bloom_tiles.cells(tile);
      std::vector<std::uint64_t>& glow = painter.glow.emplace_back(cells.lanes());
      std::memcpy(glow.data(), in.take(cells.lanes() * sizeof(std::uint64_t)).data(), glow.size() * sizeof glow[0]);
    }
  });
  session.comm().reuse(std::move(message));
}

}  // namespace

void open_bloom(const Rank& rank, const image::View& view, Painter& painter) {
  std::vector<image::Area> tiles;
  const int own = rank.session.rank();
  for (int slot = painter.plan.first(own); slot < painter.plan.end(own); ++slot) tiles.push_back(painter.area(slot));
  painter.bloom_tiles.begin(view, std::move(tiles), rank.pool->threads());
}

void await_glow(Rank& rank, const Painter& painter) {
  const Session& session = rank.session;
  if (session.draws()) {
    each_other(rank, painter, [&](int from) { rank.session.comm().await(from, comm::Phase::glow); });
  } else if (painter.plan.draws(session.rank())) {
    rank.session.comm().await(session.cast().image_generator, comm::Phase::glow);
  }
}

void put_averages(const Painter& painter, int tile, bool blank, base::Bytes& out) {
  const auto averages = std::as_bytes(painter.bloom_tiles.averages(static_cast<std::size_t>(tile)));
  out.put_raw(averages.data(), averages.size());
  out.put(static_cast<std::uint8_t>(blank));
}

void spread_glow(Rank& rank, const image::View& view, Painter& painter) {
  if (rank.session.draws()) {
    spread_all(rank, view, painter);
  } else if (painter.plan.draws(rank.session.rank()) && !rank.session.failed()) {
    take_glow(rank, view, painter);
  }
}

void show_tiles(Rank& rank, const image::View& view, Painter& painter) {
  const Session& session = rank.session;
  const int first = painter.plan.first(session.rank()), end = painter.plan.end(session.rank());
  if (first == end || session.failed()) return;
  const TileOutput output(rank, view, painter);
  if (session.draws()) {
    draw_some(rank, view, painter, [&] {
      rank.pool->run(painter.bloom_tiles.tiles(), [&](std::size_t tile, std::size_t worker) {
        const image::TileLight light = painter.bloom_tiles.mix(tile, painter.bloom.cells(), worker);
        output.show(painter.workers[worker].painter, light, first + static_cast<int>(tile));
      });
    });
    return;
  }
  for (const Parcel& parcel : parcels_of(painter.plan, session.rank(), view)) {
    const auto put = [&](int slot, std::size_t worker, base::Bytes& bytes) {
      const auto tile = static_cast<std::size_t>(slot - first);
      const CellArea& cells = painter.bloom_tiles.cells(tile);
      const image::BloomCells glow{cells, painter.glow[tile].data(), cells.row_lanes()};
      const image::TileLight light = painter.bloom_tiles.mix(tile, glow, worker);
      output.put(painter.workers[worker].painter, light, slot, false, bytes);
    };
    const auto draw = [&](base::Bytes& out) { put_slots(*rank.pool, parcel.first, parcel.end, out, put); };
    if (!draw_and_send(rank, view, painter, comm::Phase::tiles, draw)) return;
  }
}

}  // namespace motes::engine
