#include "image/records.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <stdexcept>
#include <string>

#include "image/camera.h"
#include "image/footprint.h"
#include "image/layout.h"
#include "particles/enumerators.h"

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
  std::uint16_t width = 0;
  std::uint16_t height = 0;
  std::uint32_t first = 0;
  std::uint32_t tiles = 0;
  std::uint32_t batches = 0;
  std::uint64_t records = 0;
};
static_assert(sizeof(Header) == 32);

// Particles per batch: its projected columns and its records (some 800 kB) stay in the second-level cache, so that
// neither sorting nor the many streams of tiles touch main memory. Images of very many tiles need longer batches, or
// the offsets would outweigh the records.
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

// Counts the records of each tile at counts[tile + 1], and lists the particles that touch several tiles. Free of
// branches: which particles touch several is random, and a misprediction costs more than the work.
std::size_t count_tiles(const ProjectedBatch& b, std::size_t count, std::size_t columns, std::uint32_t* counts,
                        std::uint32_t* several) {
  std::size_t listed = 0;
  for (std::size_t i = 0; i < count; ++i) {
    ++counts[(b.tile[i] & kTileNumber) + 1];
    several[listed] = static_cast<std::uint32_t>(i);
    listed += b.tile[i] > kTileNumber;
  }
  for (std::size_t k = 0; k < listed; ++k) {
    const std::uint32_t word = b.tile[several[k]];
    const std::uint32_t column = word >> 30 & 1, row = word >> 31;
    std::uint32_t* tile = counts + (word & kTileNumber) + 1;
    tile[1] += column;
    tile[columns] += row;
    tile[columns + 1] += column & row;
  }
  return listed;
}

// Prefetches memory that is about to be written in random order.
void prefetch_for_write(std::byte* from, std::size_t count) {
  for (std::size_t i = 0; i < count; i += 64) __builtin_prefetch(from + i, 1);
}

// Writes each record to the next place of each of its tiles.
template <bool kDepth>
void scatter(const ProjectedBatch& b, std::size_t count, std::size_t columns, std::uint32_t* cursor,
             const std::uint32_t* several, std::size_t listed, std::byte* records) {
  constexpr std::size_t kBytes = kDepth ? 12 : 8;
  const auto put = [&](std::size_t i, std::byte* to) {
    std::memcpy(to, b.position + i, 4);
    std::memcpy(to + 4, b.color + i, 4);
    if (kDepth) std::memcpy(to + 8, b.depth + i, 4);
  };
  for (std::size_t i = 0; i < count; ++i) put(i, records + cursor[b.tile[i] & kTileNumber]++ * kBytes);
  std::byte nowhere[kBytes];
  const auto put_if = [&](std::size_t i, std::size_t tile, std::uint32_t wanted) {
    put(i, wanted != 0 ? records + cursor[tile] * kBytes : nowhere);
    cursor[tile] += wanted;
  };
  for (std::size_t k = 0; k < listed; ++k) {
    const std::uint32_t i = several[k];
    const std::uint32_t column = b.tile[i] >> 30 & 1, row = b.tile[i] >> 31;
    const std::size_t tile = b.tile[i] & kTileNumber;
    put_if(i, tile + 1, column);
    put_if(i, tile + columns, row);
    put_if(i, tile + columns + 1, column & row);
  }
}

}  // namespace

void Projector::append_batch(const ProjectTask& task, std::size_t first, std::size_t last, bool with_depth, int tiles,
                             Records& records) {
  constexpr std::size_t kSlack = 32;  // one vector that is stored whole, and a cache line between the arrays
  const std::size_t room = last - first + kSlack;
  projected_.resize(5 * room);
  std::uint32_t* projected = projected_.data();
  const ProjectedBatch batch{projected, projected + room, with_depth ? projected + 2 * room : nullptr,
                             projected + 3 * room};
  std::uint32_t* several = projected + 4 * room;
  const std::size_t visible = lanes_->project(task, first, last, batch);
  if (visible == 0) return;

  const auto tile_count = static_cast<std::size_t>(tiles);
  const auto columns = static_cast<std::size_t>(task.columns);
  cursor_.assign(tile_count + columns + 3, 0);  // increments by 0 may go past the end
  const std::size_t listed = count_tiles(batch, visible, columns, cursor_.data(), several);
  for (std::size_t t = 0; t < tile_count; ++t) cursor_[t + 1] += cursor_[t];
  const std::size_t total = cursor_[tile_count];

  const std::size_t offset_bytes = 4 * (tile_count + 1);
  const std::size_t record_bytes = total * (with_depth ? 12 : 8);
  const std::size_t at = records.buffer_.size();
  records.buffer_.resize(at + offset_bytes + record_bytes);
  std::byte* to = records.buffer_.data() + at;
  std::memcpy(to, cursor_.data(), offset_bytes);
  to += offset_bytes;
  prefetch_for_write(to, record_bytes);
  if (with_depth) {
    scatter<true>(batch, visible, columns, cursor_.data(), several, listed, to);
  } else {
    scatter<false>(batch, visible, columns, cursor_.data(), several, listed, to);
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
  for (const float* plane : particles.position) {
    if (plane == nullptr && particles.count != 0) throw std::invalid_argument("position must have three planes");
  }
  const bool with_depth = !view.objects.empty();
  if (layout(sprite, view, with_depth) > (with_depth ? Layout::deep : Layout::plain) ||
      (sprite.kind != Sprite::Kind::point && sprite.kind != Sprite::Kind::disc)) {
    throw std::invalid_argument("sprite: this kind, size or blend cannot be drawn by this version");
  }
  const Grid grid{view.width, view.height};
  Header header;
  header.kind = static_cast<std::uint8_t>(sprite.kind);
  header.pixels = sprite.kind == Sprite::Kind::disc ? static_cast<std::uint8_t>(sprite.pixels) : std::uint8_t{1};
  header.with_depth = with_depth;
  header.width = static_cast<std::uint16_t>(view.width);
  header.height = static_cast<std::uint16_t>(view.height);
  header.tiles = static_cast<std::uint32_t>(grid.tiles());
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
  header_ = bytes.data();
  if (header.magic != kMagic) throw std::runtime_error("image records: not a message of records");
  if (header.width < 1 || header.width > kMaxSize || header.height < 1 || header.height > kMaxSize) {
    throw std::runtime_error("image records: impossible image size " + std::to_string(header.width) + "x" +
                             std::to_string(header.height));
  }
  if (header.kind >= particles::enumerators<Sprite::Kind>() || header.pixels < 1 || header.pixels > kMaxFootprint ||
      header.with_depth > 1) {
    throw std::runtime_error("image records: unknown sprite");
  }
  sprite_.kind = static_cast<Sprite::Kind>(header.kind);
  sprite_.pixels = header.pixels;
  grid_ = {header.width, header.height};
  const auto tiles = static_cast<std::uint32_t>(grid_.tiles());
  if (header.first > tiles || header.tiles > tiles - header.first) {
    throw std::runtime_error("image records: tiles outside the image");
  }
  first_ = static_cast<int>(header.first);
  tiles_ = static_cast<int>(header.tiles);
  with_depth_ = header.with_depth != 0;
  std::span<const std::byte> rest = bytes.subspan(sizeof header);
  if (header.batches > rest.size() / 4) throw std::runtime_error("image records: message ends too early");
  batches_.reserve(header.batches);
  for (std::uint32_t i = 0; i < header.batches; ++i) batches_.push_back(take_batch(rest));
  if (!rest.empty() || count_ != header.records) throw std::runtime_error("image records: sizes do not agree");
}

RecordsView::Batch RecordsView::take_batch(std::span<const std::byte>& rest) {
  const auto tiles = static_cast<std::size_t>(tiles_);
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
  if (tile < first_ || tile - first_ >= tiles_) return {batch.records, 0};
  const auto t = static_cast<std::size_t>(tile - first_);
  const std::uint32_t first = word_at(batch.offsets, t);
  return {batch.records + first * record_bytes(), word_at(batch.offsets, t + 1) - first};
}

std::size_t RecordsView::count(int first, int end) const {
  std::size_t count = 0;
  for (const Batch& batch : batches_) {
    count += word_at(batch.offsets, static_cast<std::size_t>(end - first_)) -
             word_at(batch.offsets, static_cast<std::size_t>(first - first_));
  }
  return count;
}

void RecordsView::append_part(int first, int end, particles::Bytes& out) const {
  if (first < first_ || end < first || end > first_ + tiles_) {
    throw std::invalid_argument("image records: a part of tiles that are not in the message");
  }
  const std::size_t total = count(first, end);
  Header header;
  std::memcpy(&header, header_, sizeof header);
  header.first = static_cast<std::uint32_t>(first);
  header.tiles = static_cast<std::uint32_t>(end - first);
  header.batches = 0;
  header.records = total;
  const auto from = static_cast<std::size_t>(first - first_), to = static_cast<std::size_t>(end - first_);
  const std::size_t offset_bytes = 4 * (to - from + 1);
  const std::size_t at = out.size();
  out.reserve(at + sizeof header + batches_.size() * offset_bytes + total * record_bytes());
  out.put_raw(&header, sizeof header);
  for (const Batch& batch : batches_) {
    const std::uint32_t before = word_at(batch.offsets, from);
    const std::size_t records = word_at(batch.offsets, to) - before;
    if (records == 0) continue;
    std::byte* offsets = out.extend(offset_bytes);
    for (std::size_t t = from; t <= to; ++t, offsets += 4) {
      const std::uint32_t offset = word_at(batch.offsets, t) - before;
      std::memcpy(offsets, &offset, 4);
    }
    out.put_raw(batch.records + before * record_bytes(), records * record_bytes());
    ++header.batches;
  }
  out.set(at, header);
}

}  // namespace motes::image
