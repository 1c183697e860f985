#include "image/ordered.h"

#include <algorithm>
#include <array>
#include <cstring>

namespace motes::image {
namespace {

// Below this, passes over counters cost more than comparing.
constexpr std::size_t kWorthCounting = 64;
constexpr int kDigitBits = 11;
constexpr std::size_t kDigits = std::size_t{1} << kDigitBits;

std::uint32_t depth_of(const Brush& brush, const std::byte* record) {
  if (!has_depth(brush.layout())) return 0;
  std::uint32_t bits;
  std::memcpy(&bits, record + form(brush.layout()).depth, sizeof bits);
  return bits;
}

}  // namespace

void Ordered::sort(std::span<const Piece> pieces) {
  keys_.clear();
  entries_.clear();
  for (const Piece& piece : pieces) {
    if (piece.brush->blends(Sprite::Blend::opaque)) continue;
    const std::byte* record = piece.records;
    for (std::size_t i = 0; i < piece.count; ++i, record += piece.brush->record_bytes()) {
      const std::uint64_t nearness = ~depth_of(*piece.brush, record);
      keys_.push_back(nearness << 32 | entries_.size());
      entries_.push_back({record, piece.brush});
    }
  }
  sort_keys();
  order_equals();
  gather();
}

// By the upper half only. Depths of a tile differ in few leading bits, so most sorts need two passes of three.
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
  other_keys_.resize(keys_.size());
  for (int shift = 32; shift < 64 && (greatest - least) >> shift != 0; shift += kDigitBits) {
    std::array<std::uint32_t, kDigits> count{};
    for (const std::uint64_t key : keys_) ++count[(key - least) >> shift & (kDigits - 1)];
    std::uint32_t before = 0;
    for (std::uint32_t& c : count) {
      const std::uint32_t here = c;
      c = before;
      before += here;
    }
    for (const std::uint64_t key : keys_) other_keys_[count[(key - least) >> shift & (kDigits - 1)]++] = key;
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
  std::size_t bytes = 0;
  for (const Entry& entry : entries_) bytes += entry.brush->record_bytes();
  records_.resize(bytes);
  std::byte* to = records_.data();
  for (const std::uint64_t key : keys_) {
    const Entry& entry = entries_[key & 0xffffffffu];
    const std::size_t size = entry.brush->record_bytes();
    if (runs_.empty() || runs_.back().brush != entry.brush) runs_.push_back({entry.brush, to, 0});
    ++runs_.back().count;
    std::memcpy(to, entry.record, size);
    to += size;
  }
}

}  // namespace motes::image
