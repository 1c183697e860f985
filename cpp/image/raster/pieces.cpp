#include "image/raster/pieces.h"

#include <stdexcept>
#include <utility>

namespace motes::image {

void Pieces::begin(const View& view, const Slots& slots) {
  const bool stands = view == view_;
  if (!parts_.empty() || !stands) {
    std::erase_if(brushes_, [&](const Brush& brush) {
      const auto drawn_by = [&](const Part& part) { return part.brush == &brush; };
      return !stands || !brush.lasts() || std::none_of(parts_.begin(), parts_.end(), drawn_by);
    });
  }
  parts_.clear();
  view_ = view;
  slots_ = slots;
}

void Pieces::add(std::span<const std::byte> message) {
  RecordsView seen(message);
  if (seen.grid().width != view_.width || seen.grid().height != view_.height ||
      (!seen.with_depth() && !view_.objects.empty()) || seen.with_velocity() != with_velocity(seen.sprite(), view_)) {
    throw std::runtime_error("image records: made for a different view");
  }
  const Brush& brush = brush_for(seen);
  parts_.push_back({std::move(seen), &brush});
}

// Returns the brush for a message; systems with equal sprites share one.
const Brush& Pieces::brush_for(const RecordsView& records) {
  for (const Brush& brush : brushes_) {
    if (brush.same(records.sprite(), records.layout(), records.colored())) return brush;
  }
  return brushes_.emplace_back(records.sprite(), records.layout(), view_, records.colored());
}

std::size_t Pieces::collect(int tile, std::vector<Piece>& pieces) const {
  pieces.clear();
  const int slot = slots_.slot(tile);
  std::size_t count = 0;
  for (const Part& part : parts_) {
    for (const RecordsView::Batch& batch : part.records.batches()) {
      const RecordsView::RecordRun piece = part.records.piece(batch, slot);
      if (piece.count == 0) continue;
      pieces.push_back({part.brush, piece.records, piece.count, part.records.most_alpha(), part.records.color()});
      count += piece.count;
    }
  }
  return count;
}

}  // namespace motes::image
