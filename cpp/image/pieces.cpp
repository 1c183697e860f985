#include "image/pieces.h"

#include <stdexcept>
#include <utility>

#include "image/camera.h"
#include "image/footprint.h"

namespace motes::image {

Brush::Brush(const RecordsView& records)
    : sprite(records.sprite()), grid(records.grid()), record_bytes(records.record_bytes()), splat{} {
  const Footprint& f = footprint(sprite);
  splat.weights = f.weights.data();
  splat.size = f.size;
  splat.phase_bits = f.phase_bits;
  splat.row_bytes = f.row_bytes;
  splat.sub_bits = grid.sub_bits();
  splat.with_depth = records.with_depth();
}

void Pieces::begin(const View& view) {
  parts_.clear();
  grid_ = {view.width, view.height};
  with_depth_ = !view.objects.empty();
}

void Pieces::add(std::span<const std::byte> message) {
  RecordsView seen(message);
  check_drawn(seen.sprite());
  if (seen.grid().width != grid_.width || seen.grid().height != grid_.height || seen.with_depth() != with_depth_) {
    throw std::runtime_error("image records: made for a different view");
  }
  const Brush brush(seen);
  parts_.push_back({std::move(seen), brush});
}

std::size_t Pieces::collect(int tile, std::vector<Piece>& pieces) const {
  pieces.clear();
  std::size_t count = 0;
  for (const Part& part : parts_) {
    for (const RecordsView::Batch& batch : part.records.batches()) {
      const RecordsView::Piece piece = part.records.piece(batch, tile);
      if (piece.count == 0) continue;
      pieces.push_back({&part.brush, piece.records, piece.count});
      count += piece.count;
    }
  }
  return count;
}

}  // namespace motes::image
