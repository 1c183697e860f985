#include "frame/render_composite.h"

#include <stdexcept>

namespace motes::frame {

// tile u32, records u64, size u64, then the partial tile.
std::uint64_t put_partials(const Rank& rank, Painter& painter, int first, int end, particles::Bytes& out) {
  std::uint64_t all = 0;
  int made = 0;
  for (int slot = first; slot < end; ++slot) {
    const int tile = painter.slots.tile(slot);
    painter.pieces.collect(tile, painter.of_tile);
    std::erase_if(painter.of_tile, [&](const image::Piece& piece) { return !piece.brush->blends(*painter.merged); });
    std::uint64_t records = 0;
    for (const image::Piece& piece : painter.of_tile) records += piece.count;
    if (records == 0) continue;
    painter.scene.render({&tile, 1});  // objects hide what is behind them
    painter.tile.start_bare(painter.scene.grid().area(tile));
    painter.tile.paint(painter.of_tile);
    painter.partial.resize(0);
    painter.tile.save_partial(painter.partial);
    out.put(static_cast<std::uint32_t>(tile));
    out.put(records);
    out.put(static_cast<std::uint64_t>(painter.partial.size()));
    out.put_raw(painter.partial.data(), painter.partial.size());
    all += records;
    ++made;
  }
  rank.machine.charge_once(rank.machine.costs().picture * made / painter.scene.grid().tiles());
  rank.machine.charge(rank.machine.costs().draw * static_cast<double>(all));
  return all;
}

void Partials::next() {
  tile_ = -1;
  if (in_.done()) return;
  tile_ = static_cast<int>(in_.get<std::uint32_t>());
  records_ = in_.get<std::uint64_t>();
  bytes_ = in_.take(in_.get<std::uint64_t>());
}

std::uint64_t Partials::add_to(int tile, image::TilePainter& painter) {
  if (tile_ != tile) return 0;
  painter.merge(bytes_);
  const std::uint64_t records = records_;
  next();
  return records;
}

void Partials::check_done() const {
  if (tile_ >= 0) throw std::runtime_error("a message has a partial tile of another rank, or twice the same");
}

}  // namespace motes::frame
