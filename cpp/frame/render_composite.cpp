#include "frame/render_composite.h"

#include <algorithm>
#include <stdexcept>

namespace motes::frame {

namespace {

// Slots of a thread at a time.
constexpr int kSlots = 8;

struct Made {
  particles::Bytes bytes;
  std::uint64_t records = 0;
  int tiles = 0;
};

// tile u32, records u64, size u64, then the partial tile.
void put_partial(const Painter& painter, image::PreparedScene& scene, int tile, std::size_t worker,
                 image::TileWorker& by, Made& made) {
  painter.pieces.collect(tile, by.pieces);
  std::erase_if(by.pieces, [&](const image::Piece& piece) { return !piece.brush->blends(*painter.merged); });
  std::uint64_t records = 0;
  for (const image::Piece& piece : by.pieces) records += piece.count;
  if (records == 0) return;
  scene.render(tile, worker);  // objects hide what is behind them
  by.painter.start_bare(scene.grid().area(tile));
  by.painter.paint(by.pieces);
  by.partial.resize(0);
  by.painter.save_partial(by.partial);
  made.bytes.put(static_cast<std::uint32_t>(tile));
  made.bytes.put(records);
  made.bytes.put(static_cast<std::uint64_t>(by.partial.size()));
  made.bytes.put_raw(by.partial.data(), by.partial.size());
  made.records += records;
  ++made.tiles;
}

}  // namespace

std::uint64_t put_partials(const Rank& rank, Painter& painter, int first, int end, particles::Bytes& out) {
  std::vector<Made> parts(static_cast<std::size_t>((end - first + kSlots - 1) / kSlots));
  rank.pool->run(parts.size(), [&](std::size_t part, std::size_t worker) {
    const int begin = first + static_cast<int>(part) * kSlots;
    for (int slot = begin; slot < std::min(end, begin + kSlots); ++slot) {
      put_partial(painter, painter.scene, painter.slots.tile(slot), worker, painter.workers[worker], parts[part]);
    }
  });
  std::uint64_t all = 0;
  int made = 0;
  for (const Made& part : parts) {
    out.put_raw(part.bytes.data(), part.bytes.size());
    all += part.records;
    made += part.tiles;
  }
  rank.machine.charge_once(rank.machine.costs().picture * made / painter.scene.grid().tiles());
  rank.machine.charge(rank.machine.costs().draw * static_cast<double>(all));
  return all;
}

Partials::Partials(particles::Reader in, const Painter& painter, int first, int end)
    : first_(first), partials_(static_cast<std::size_t>(end - first)) {
  while (!in.done()) {
    const auto tile = in.get<std::uint32_t>();
    const bool known = tile < static_cast<std::uint32_t>(painter.scene.grid().tiles());
    const int slot = known ? painter.slots.slot(static_cast<int>(tile)) : -1;
    Partial partial;
    partial.records = in.get<std::uint64_t>();
    partial.bytes = in.take(in.get<std::uint64_t>());
    if (slot < first || slot >= end || has(slot)) {
      throw std::runtime_error("a message has a partial tile of another rank, or twice the same");
    }
    partials_[static_cast<std::size_t>(slot - first)] = partial;
  }
}

std::uint64_t Partials::add_to(int slot, image::TilePainter& painter) const {
  if (!has(slot)) return 0;
  painter.merge(of(slot).bytes);
  return of(slot).records;
}

}  // namespace motes::frame
