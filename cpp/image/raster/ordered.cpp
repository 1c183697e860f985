#include "image/raster/ordered.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <numeric>
#include <stdexcept>

namespace motes::image {
namespace {

// Fewest keys for a radix sort; below, passes over counters cost more than comparisons.
constexpr std::size_t kFewestKeys = 256;
constexpr int kMostDigitBits = 12, kMostPasses = 3;  // of 32 bits

constexpr std::size_t kDeepBytes = sizeof(DeepRecord);

// Counts of each digit value, one array per pass.
using DigitCounts = std::array<std::array<std::uint32_t, std::size_t{1} << kMostDigitBits>, kMostPasses>;

// Counts the digits of (upper half - least) for all passes, lowest first.
template <int kPasses>
void count_digits(std::span<const std::uint64_t> keys, std::uint32_t least, int digit_bits, DigitCounts& counts) {
  const std::uint32_t mask = (std::uint32_t{1} << digit_bits) - 1;
  for (const std::uint64_t key : keys) {
    const std::uint32_t above = static_cast<std::uint32_t>(key >> 32) - least;
    for (int pass = 0; pass < kPasses; ++pass) {
      ++counts[static_cast<std::size_t>(pass)][above >> pass * digit_bits & mask];
    }
  }
}

}  // namespace

void Ordered::sort(std::span<const Piece> pieces) {
  const auto is_wanted = [](const Piece& piece) {
    return piece.count != 0 && !piece.brush->blends(Sprite::Blend::opaque);
  };
  count_ = 0;
  bytes_ = 0;
  most_alpha_ = 0;
  brush_ = nullptr;
  bool alike = true;
  for (const Piece& piece : pieces) {
    if (!is_wanted(piece)) continue;
    if (!piece.brush->colored()) throw std::runtime_error("image records: colours are missing");
    if (brush_ == nullptr) brush_ = piece.brush;
    alike &= piece.brush == brush_;
    count_ += piece.count;
    bytes_ += piece.count * piece.brush->record_bytes();
    most_alpha_ = std::max(most_alpha_, piece.most_alpha);
  }
  if (!alike) brush_ = nullptr;
  keys_.resize(count_);
  brush_ != nullptr ? listed_.resize(bytes_) : entries_.resize(count_);
  least_ = ~std::uint32_t{0};
  greatest_ = 0;
  std::size_t first = 0, at = 0;
  for (const Piece& piece : pieces) {
    if (!is_wanted(piece)) continue;
    list(piece, first, at);
    first += piece.count;
    at += piece.count * piece.brush->record_bytes();
  }
  sort_keys();
  gather();
}

// Appends the keys of a piece. If all records have the same brush they are copied, so that a record's index determines
// its address.
void Ordered::list(const Piece& piece, std::size_t first, std::size_t at) {
  const std::size_t size = piece.brush->record_bytes();
  const bool deep = has_depth(piece.brush->layout());
  const std::size_t depth = deep ? static_cast<std::size_t>(form(piece.brush->layout()).depth) : 0;
  const std::byte* record = piece.records;
  if (brush_ != nullptr) {
    std::memcpy(listed_.data() + at, record, piece.count * size);
  } else {
    for (std::size_t i = 0; i < piece.count; ++i) entries_.data()[first + i] = {record + i * size, piece.brush};
  }
  std::uint64_t* keys = keys_.data() + first;
  for (std::size_t i = 0; i < piece.count; ++i, record += size) {
    std::uint32_t bits = 0;
    if (deep) std::memcpy(&bits, record + depth, sizeof bits);
    least_ = std::min(least_, ~bits);
    greatest_ = std::max(greatest_, ~bits);
    keys[i] = std::uint64_t{~bits} << 32 | (first + i);
  }
}

// Radix-sorts keys by their upper half, in as few passes as the range of depths needs: two for most tiles.
void Ordered::sort_keys() {
  if (count_ < kFewestKeys) {
    std::sort(keys_.data(), keys_.data() + count_);
    return;
  }
  const auto bits = static_cast<int>(std::bit_width(greatest_ - least_));
  const int passes = (bits + kMostDigitBits - 1) / kMostDigitBits;
  if (passes == 0) return;
  const int digit_bits = (bits + passes - 1) / passes;
  const std::uint32_t mask = (std::uint32_t{1} << digit_bits) - 1;
  DigitCounts counts;
  for (int pass = 0; pass < passes; ++pass) std::fill_n(counts[static_cast<std::size_t>(pass)].begin(), mask + 1, 0u);
  const std::span<const std::uint64_t> keys(keys_.data(), count_);
  if (passes == 1) count_digits<1>(keys, least_, digit_bits, counts);
  if (passes == 2) count_digits<2>(keys, least_, digit_bits, counts);
  if (passes == 3) count_digits<3>(keys, least_, digit_bits, counts);
  other_keys_.resize(count_);
  for (int pass = 0; pass < passes; ++pass) {
    std::uint32_t* places = counts[static_cast<std::size_t>(pass)].data();
    std::exclusive_scan(places, places + mask + 1, places, 0u);
    const int shift = pass * digit_bits;
    std::uint64_t* to = other_keys_.data();
    for (std::size_t i = 0; i < count_; ++i) {
      const std::uint64_t key = keys_.data()[i];
      to[places[(static_cast<std::uint32_t>(key >> 32) - least_) >> shift & mask]++] = key;
    }
    std::swap(keys_, other_keys_);
  }
}

Ordered::Entry Ordered::entry(std::uint64_t key) const {
  const std::size_t number = key & 0xffffffffu;
  if (brush_ != nullptr) return {listed_.data() + number * brush_->record_bytes(), brush_};
  return entries_.data()[number];
}

// Returns whether the i-th key is the first of several with the same depth; `before` is the key before it.
bool Ordered::begins_equals(std::size_t i, std::uint64_t before) const {
  const std::uint64_t* keys = keys_.data();
  return i + 1 < count_ && (keys[i] ^ keys[i + 1]) >> 32 == 0 && (keys[i] ^ before) >> 32 != 0;
}

// Sorts the equally deep records from `first` on by content.
void Ordered::order_equals(std::size_t first) {
  const auto before = [&](std::uint64_t a, std::uint64_t b) {
    const Entry one = entry(a), other = entry(b);
    if (one.brush != other.brush) return *one.brush < *other.brush;
    return std::memcmp(one.record, other.record, one.brush->record_bytes()) < 0;
  };
  std::uint64_t* keys = keys_.data();
  std::size_t end = first + 1;
  while (end < count_ && keys[end] >> 32 == keys[first] >> 32) ++end;
  std::sort(keys + first, keys + end, before);
}

void Ordered::gather() {
  runs_.clear();
  if (count_ == 0) return;
  records_.resize(bytes_);
  if (brush_ == nullptr) return gather_each();
  runs_.push_back({brush_, records_.data(), count_, most_alpha_});
  // Most records have this size; with a constant size memcpy is inlined.
  brush_->record_bytes() == kDeepBytes ? copy_alike<kDeepBytes>(kDeepBytes) : copy_alike<0>(brush_->record_bytes());
}

// Copies records of one brush in order. kSize: bytes of a record; 0: use `size`.
template <std::size_t kSize>
void Ordered::copy_alike(std::size_t size) {
  const std::byte* from = listed_.data();
  std::byte* to = records_.data();
  const std::uint64_t* keys = keys_.data();
  std::uint64_t before = ~keys[0];
  for (std::size_t i = 0; i < count_; ++i, to += kSize != 0 ? kSize : size) {
    if (begins_equals(i, before)) order_equals(i);
    before = keys[i];
    const std::byte* record = from + (before & 0xffffffffu) * (kSize != 0 ? kSize : size);
    kSize != 0 ? std::memcpy(to, record, kSize) : std::memcpy(to, record, size);
  }
}

void Ordered::gather_each() {
  std::byte* to = records_.data();
  const std::uint64_t* keys = keys_.data();
  std::uint64_t before = ~keys[0];
  for (std::size_t i = 0; i < count_; ++i) {
    if (begins_equals(i, before)) order_equals(i);
    before = keys[i];
    const Entry next = entry(before);
    const std::size_t size = next.brush->record_bytes();
    if (runs_.empty() || runs_.back().brush != next.brush) runs_.push_back({next.brush, to, 0, most_alpha_});
    ++runs_.back().count;
    std::memcpy(to, next.record, size);
    to += size;
  }
}

}  // namespace motes::image
