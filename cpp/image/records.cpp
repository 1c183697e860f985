#include "image/records.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <stdexcept>
#include <string>

#include "image/camera.h"
#include "image/footprint.h"

namespace motes::image {
namespace {

static_assert(std::endian::native == std::endian::little, "messages are little-endian");

constexpr std::uint32_t kMagic = 0x3153544d;  // "MTS1"

struct Header {
  std::uint32_t magic = kMagic;
  std::uint8_t kind = 0;
  std::uint8_t pixels = 0;
  std::uint8_t with_depth = 0;
  std::uint8_t zero = 0;
  std::int32_t width = 0;
  std::int32_t height = 0;
  std::uint32_t batches = 0;
  std::uint32_t zero_too = 0;
  std::uint64_t records = 0;
};
static_assert(sizeof(Header) == 32);

// Particles a batch: its words and its records (some 800 kB) stay in the second cache, so that neither sorting nor
// the many streams of tiles touch main memory. Images of very many tiles need longer batches, or offsets would
// outweigh records.
std::size_t batch_size(int tiles) { return std::max<std::size_t>(32768, 16 * static_cast<std::size_t>(tiles)); }

std::uint32_t word_at(const std::byte* from, std::size_t index) {
  std::uint32_t word;
  std::memcpy(&word, from + 4 * index, sizeof word);
  return word;
}

void copy(const Vector& from, float (&to)[3]) {
  for (std::size_t i = 0; i < 3; ++i) to[i] = static_cast<float>(from[i]);
}

ProjectTask task_of(const Drawn& particles, const Sprite& sprite, const View& view) {
  const Grid grid{view.width, view.height};
  const Lens lens = image::lens(view);
  ProjectTask t{};
  for (std::size_t i = 0; i < 3; ++i) {
    t.position[i] = particles.position[i];
    t.color[i] = particles.color[i];
    t.color_of_all[i] = particles.color_of_all[i];
  }
  t.alpha = particles.alpha;
  t.alpha_of_all = particles.alpha_of_all;
  copy(lens.eye, t.eye);
  copy(lens.right, t.right);
  copy(lens.up, t.up);
  copy(lens.forward, t.forward);
  t.sub_bits = grid.sub_bits();
  const int unit = 1 << t.sub_bits;
  t.scale = static_cast<float>(lens.focal_px * unit);
  t.near = static_cast<float>(view.camera.near);
  t.width = grid.width;
  t.height = grid.height;
  t.columns = grid.columns();
  t.footprint = footprint_size(sprite);
  // Half the image and the largest footprint; at most 32768 - 1 (see Grid::sub_bits).
  t.limit_x = static_cast<float>((grid.width + 1) / 2 * unit + 12 * unit);
  t.limit_y = static_cast<float>((grid.height + 1) / 2 * unit + 12 * unit);
  return t;
}

// Number of records in each tile, at counts[tile + 1].
void count_tiles(const std::uint32_t* words, std::size_t count, int columns, std::uint32_t* counts) {
  for (std::size_t i = 0; i < count; ++i) {
    std::uint32_t* tile = counts + (words[i] & kTileNumber) + 1;
    ++tile[0];
    if ((words[i] & ~kTileNumber) == 0) continue;
    const bool column = (words[i] & kNextColumn) != 0;
    const bool row = (words[i] & kNextRow) != 0;
    if (column) ++tile[1];
    if (row) ++tile[columns];
    if (column && row) ++tile[columns + 1];
  }
}

// Writes record i to the next place of each of its tiles.
template <bool kDepth>
void scatter(const ProjectedBatch& b, std::size_t count, int columns, std::uint32_t* cursor, std::byte* records) {
  const auto put = [&](std::size_t i, std::uint32_t tile) {
    std::byte* to = records + static_cast<std::size_t>(cursor[tile]++) * (kDepth ? 12 : 8);
    std::memcpy(to, b.position + i, 4);
    std::memcpy(to + 4, b.color + i, 4);
    if (kDepth) std::memcpy(to + 8, b.depth + i, 4);
  };
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t tile = b.tile[i] & kTileNumber;
    put(i, tile);
    if ((b.tile[i] & ~kTileNumber) == 0) continue;
    const bool column = (b.tile[i] & kNextColumn) != 0;
    const bool row = (b.tile[i] & kNextRow) != 0;
    const auto below = tile + static_cast<std::uint32_t>(columns);
    if (column) put(i, tile + 1);
    if (row) put(i, below);
    if (column && row) put(i, below + 1);
  }
}

}  // namespace

void Projector::append_batch(const ProjectTask& task, std::size_t first, std::size_t last, bool with_depth, int tiles,
                             Records& records) {
  constexpr std::size_t kSlack = 32;  // one vector that is stored whole, and a cache line between the arrays
  const std::size_t room = last - first + kSlack;
  words_.resize(4 * room);
  std::uint32_t* words = words_.data();
  const ProjectedBatch batch{words, words + room, with_depth ? words + 2 * room : nullptr, words + 3 * room};
  const std::size_t visible = lanes_->project(task, first, last, batch);
  if (visible == 0) return;

  const auto tile_count = static_cast<std::size_t>(tiles);
  cursor_.assign(tile_count + 1, 0);
  count_tiles(batch.tile, visible, task.columns, cursor_.data());
  for (std::size_t t = 0; t < tile_count; ++t) cursor_[t + 1] += cursor_[t];
  const std::size_t total = cursor_[tile_count];

  const std::size_t offset_bytes = 4 * (tile_count + 1);
  const std::size_t at = records.buffer_.size();
  records.buffer_.resize(at + offset_bytes + total * (with_depth ? 12 : 8));
  std::byte* to = records.buffer_.data() + at;
  std::memcpy(to, cursor_.data(), offset_bytes);
  if (with_depth) {
    scatter<true>(batch, visible, task.columns, cursor_.data(), to + offset_bytes);
  } else {
    scatter<false>(batch, visible, task.columns, cursor_.data(), to + offset_bytes);
  }
  Header header;
  std::memcpy(&header, records.buffer_.data(), sizeof header);
  ++header.batches;
  header.records += total;
  std::memcpy(records.buffer_.data(), &header, sizeof header);
}

void Projector::project(const Drawn& particles, const Sprite& sprite, const View& view, Records& records) {
  check(view);
  check(sprite);
  const Grid grid{view.width, view.height};
  const bool with_depth = !view.objects.empty();
  Header header;
  header.kind = static_cast<std::uint8_t>(sprite.kind);
  header.pixels = sprite.kind == Sprite::Kind::disc ? static_cast<std::uint8_t>(sprite.pixels) : std::uint8_t{1};
  header.with_depth = with_depth;
  header.width = view.width;
  header.height = view.height;
  records.buffer_.resize(sizeof header);
  std::memcpy(records.buffer_.data(), &header, sizeof header);

  const ProjectTask task = task_of(particles, sprite, view);
  const std::size_t step = batch_size(grid.tiles());
  for (std::size_t first = 0; first < particles.count; first += step) {
    append_batch(task, first, std::min(first + step, particles.count), with_depth, grid.tiles(), records);
  }
}

RecordsView::RecordsView(std::span<const std::byte> bytes) {
  Header header;
  if (bytes.size() < sizeof header) throw std::runtime_error("image records: message is too short");
  std::memcpy(&header, bytes.data(), sizeof header);
  if (header.magic != kMagic) throw std::runtime_error("image records: not a message of records");
  if (header.width < 1 || header.width > kMaxSize || header.height < 1 || header.height > kMaxSize) {
    throw std::runtime_error("image records: impossible image size " + std::to_string(header.width) + "x" +
                             std::to_string(header.height));
  }
  if (header.kind > 1 || header.pixels < 1 || header.pixels > kMaxFootprint || header.with_depth > 1) {
    throw std::runtime_error("image records: unknown sprite");
  }
  sprite_ = {static_cast<Sprite::Kind>(header.kind), header.pixels};
  grid_ = {header.width, header.height};
  with_depth_ = header.with_depth != 0;
  std::span<const std::byte> rest = bytes.subspan(sizeof header);
  if (header.batches > rest.size() / 4) throw std::runtime_error("image records: message ends too early");
  batches_.reserve(header.batches);
  for (std::uint32_t i = 0; i < header.batches; ++i) batches_.push_back(take_batch(rest));
  if (!rest.empty() || count_ != header.records) throw std::runtime_error("image records: sizes do not agree");
}

RecordsView::Batch RecordsView::take_batch(std::span<const std::byte>& rest) {
  const auto tiles = static_cast<std::size_t>(grid_.tiles());
  const std::size_t offset_bytes = 4 * (tiles + 1);
  if (rest.size() < offset_bytes) throw std::runtime_error("image records: message ends too early");
  const Batch batch{rest.data(), rest.data() + offset_bytes};
  std::uint32_t before = 0;
  bool ascending = word_at(batch.offsets, 0) == 0;
  for (std::size_t t = 1; t <= tiles; ++t) {
    const std::uint32_t offset = word_at(batch.offsets, t);
    ascending &= offset >= before;
    before = offset;
  }
  if (!ascending) throw std::runtime_error("image records: offsets are not ascending");
  const std::size_t record_total = static_cast<std::size_t>(before) * record_bytes();
  if (rest.size() - offset_bytes < record_total) throw std::runtime_error("image records: message ends too early");
  rest = rest.subspan(offset_bytes + record_total);
  count_ += before;
  return batch;
}

RecordsView::Piece RecordsView::piece(const Batch& batch, int tile) const {
  const auto t = static_cast<std::size_t>(tile);
  const std::uint32_t first = word_at(batch.offsets, t);
  return {batch.records + first * record_bytes(), word_at(batch.offsets, t + 1) - first};
}

}  // namespace motes::image
