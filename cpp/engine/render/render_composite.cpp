#include "engine/render/render_composite.h"

#include <atomic>
#include <stdexcept>

#include "engine/render/render_slots.h"

namespace motes::engine {

namespace {

// Draws the records that touch a tile into a partial tile and appends it, or nothing if there are no records:
//
//     u32 tile | u64 records | u64 size | partial tile
//
// Returns the number of records.
std::uint64_t put_partial(Painter& painter, int tile, std::size_t worker, base::Bytes& out) {
  image::TileWorker& by = painter.workers[worker];
  painter.pieces.collect(tile, by.pieces);
  std::erase_if(by.pieces, [&](const image::Piece& piece) { return !piece.brush->blends(*painter.merged); });
  std::uint64_t records = 0;
  for (const image::Piece& piece : by.pieces) records += piece.count;
  if (records == 0) return 0;
  painter.scene.render(tile, worker);  // solids hide particles behind them
  by.painter.start_bare(painter.scene.grid().area(tile));
  by.painter.paint(by.pieces);
  by.partial.resize(0);
  by.painter.save_partial(by.partial);
  out.put(static_cast<std::uint32_t>(tile));
  out.put(records);
  out.put(static_cast<std::uint64_t>(by.partial.size()));
  out.put_raw(by.partial.data(), by.partial.size());
  return records;
}

}  // namespace

std::uint64_t put_partials(const Rank& rank, Painter& painter, int first, int end, base::Bytes& out) {
  std::atomic<std::uint64_t> all{0};
  std::atomic<int> made{0};  // number of partial tiles
  put_slots(*rank.pool, first, end, out, [&](int slot, std::size_t worker, base::Bytes& bytes) {
    const std::uint64_t records = put_partial(painter, painter.slots.tile(slot), worker, bytes);
    all += records;
    made += records > 0 ? 1 : 0;
  });
  rank.machine.charge_once(rank.machine.costs().picture * made / painter.scene.grid().tiles());
  rank.machine.charge(rank.machine.costs().draw * static_cast<double>(all));
  return all;
}

Partials::Partials(base::Reader in, const Painter& painter, int first, int end)
    : first_(first), partials_(static_cast<std::size_t>(end - first)) {
  while (!in.done()) {
    const auto tile = in.get<std::uint32_t>();
    const bool known = tile < static_cast<std::uint32_t>(painter.scene.grid().tiles());
    const int slot = known ? painter.slots.slot(static_cast<int>(tile)) : -1;
    Partial partial;
    partial.records = in.get<std::uint64_t>();
    partial.bytes = in.take(in.get<std::uint64_t>());
    if (slot < first || slot >= end || has(slot)) {
      throw std::runtime_error("a message has a partial tile of another rank, or the same one twice");
    }
    partials_[static_cast<std::size_t>(slot - first)] = partial;
  }
}

std::uint64_t Partials::add_to(int slot, image::TilePainter& painter) const {
  if (!has(slot)) return 0;
  painter.merge(of(slot).bytes);
  return of(slot).records;
}

}  // namespace motes::engine
