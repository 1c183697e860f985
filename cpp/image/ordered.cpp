#include "image/ordered.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <numeric>

namespace motes::image {
namespace {

// With fewer keys, passes over counters cost more than comparing.
constexpr std::size_t kWorthCounting = 256;
constexpr int kMostDigitBits = 12;

constexpr std::size_t kDeepBytes = sizeof(DeepRecord);

}  // namespace

void Ordered::sort(std::span<const Piece> pieces) {
  keys_.clear();
  entries_.clear();
  bytes_ = 0;
  most_alpha_ = 0;
  for (const Piece& piece : pieces) {
    if (!piece.brush->blends(Sprite::Blend::opaque)) list(piece);
  }
  sort_keys();
  order_equals();
  gather();
}

void Ordered::list(const Piece& piece) {
  const std::size_t size = piece.brush->record_bytes(), before = keys_.size();
  const bool deep = has_depth(piece.brush->layout());
  const std::size_t depth = deep ? static_cast<std::size_t>(form(piece.brush->layout()).depth) : 0;
  keys_.resize(before + piece.count);
  entries_.resize(before + piece.count);
  bytes_ += piece.count * size;
  most_alpha_ = std::max(most_alpha_, piece.most_alpha);
  const std::byte* record = piece.records;
  for (std::size_t i = before; i < keys_.size(); ++i, record += size) {
    std::uint32_t bits = 0;
    if (deep) std::memcpy(&bits, record + depth, sizeof bits);
    keys_[i] = std::uint64_t{~bits} << 32 | i;
    entries_[i] = {record, piece.brush};
  }
}

// By the upper half only, in as few passes as the range of the depths needs: two for most tiles.
void Ordered::sort_keys() {
  if (keys_.size() < kWorthCounting) {
    std::sort(keys_.begin(), keys_.end());
    return;
  }
  std::uint64_t least = ~std::uint64_t{0}, greatest = 0;
  for (const std::uint64_t key : keys_) {
    least = std::min(least, key);
    greatest = std::max(greatest, key);
  }
  least &= ~std::uint64_t{0xffffffffu};
  const auto bits = static_cast<int>(std::bit_width((greatest - least) >> 32));
  const int passes = (bits + kMostDigitBits - 1) / kMostDigitBits;
  if (passes == 0) return;
  const int digit_bits = (bits + passes - 1) / passes;
  const std::uint64_t mask = (std::uint64_t{1} << digit_bits) - 1;
  other_keys_.resize(keys_.size());
  for (int pass = 0, shift = 32; pass < passes; ++pass, shift += digit_bits) {
    std::array<std::uint32_t, std::size_t{1} << kMostDigitBits> count;
    std::fill_n(count.begin(), mask + 1, 0u);
    for (const std::uint64_t key : keys_) ++count[(key - least) >> shift & mask];
    std::exclusive_scan(count.begin(), count.begin() + static_cast<std::ptrdiff_t>(mask + 1), count.begin(), 0u);
    for (const std::uint64_t key : keys_) other_keys_[count[(key - least) >> shift & mask]++] = key;
    keys_.swap(other_keys_);
  }
}

void Ordered::order_equals() {
  const auto depth = [](std::uint64_t key) { return key >> 32; };
  const auto before = [&](std::uint64_t a, std::uint64_t b) {
    const Entry& first = entries_[a & 0xffffffffu];
    const Entry& second = entries_[b & 0xffffffffu];
    if (first.brush != second.brush) return *first.brush < *second.brush;
    return std::memcmp(first.record, second.record, first.brush->record_bytes()) < 0;
  };
  for (std::size_t i = 0; i + 1 < keys_.size();) {
    std::size_t end = i + 1;
    while (end < keys_.size() && depth(keys_[end]) == depth(keys_[i])) ++end;
    if (end - i > 1) {
      std::sort(keys_.begin() + static_cast<std::ptrdiff_t>(i), keys_.begin() + static_cast<std::ptrdiff_t>(end),
                before);
    }
    i = end;
  }
}

void Ordered::gather() {
  runs_.clear();
  records_.resize(bytes_);
  std::byte* to = records_.data();
  for (const std::uint64_t key : keys_) {
    const Entry& entry = entries_[key & 0xffffffffu];
    const std::size_t size = entry.brush->record_bytes();
    if (runs_.empty() || runs_.back().brush != entry.brush) runs_.push_back({entry.brush, to, 0, most_alpha_});
    ++runs_.back().count;
    // Most records are of this size, and a copy of a known one is no call.
    size == kDeepBytes ? std::memcpy(to, entry.record, kDeepBytes) : std::memcpy(to, entry.record, size);
    to += size;
  }
}

}  // namespace motes::image
