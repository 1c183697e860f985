#include "surfaces/field.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "base/checks.h"

namespace motes::surfaces {
namespace {

std::uint32_t sum_of(std::uint32_t a, std::uint32_t b) {
  const std::uint32_t sum = a + b;
  return sum < a ? kMostSum : sum;
}

void add_block(NodeBlock& to, const std::uint32_t* from) {
  for (std::size_t i = 0; i < kNodes; ++i) to[i] = sum_of(to[i], from[i]);
}

// The place of the block of a node, rounded down.
std::int64_t block_of(std::int64_t node) { return node >> 3; }
static_assert(kBlock == 8);

}  // namespace

void check(const Measure& measure) {
  base::check_number("radius", measure.radius, 1e-9, 1e9);
  base::check_number("cell", measure.cell, kFinest * measure.radius, kCoarsest * measure.radius);
}

void refuse_size(const Measure& measure) {
  throw base::InvalidArgument("cell",
                              "be large enough for a grid of at most " + std::to_string(kMostBlocks * kNodes) +
                                  " nodes near particles (2 GB), and for particles within " +
                                  base::number_text(measure.cell * kBlock * static_cast<double>(kFar)) +
                                  " m of the origin",
                              base::number_text(measure.cell));
}

// The nodes that a particle reaches, from the least to the greatest along each axis, and the particle's distance from
// the first one, in reaches.
struct Field::Reach {
  std::int64_t low[3], high[3];
  float first[3];
  float step;  // between nodes, in reaches
};

void Field::add(const std::array<const float*, 3>& position, std::size_t first, std::size_t last) {
  const double reach = kReach * measure_.radius, cells = reach / measure_.cell;
  Reach r{};
  r.step = static_cast<float>(1 / cells);
  for (std::size_t i = first; i < last && !too_large(); ++i) {
    bool finite = true;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double at = double{position[axis][i]} / measure_.cell;
      finite = finite && std::isfinite(at);
      if (!finite) break;
      if (std::abs(at) > static_cast<double>((kFar - 2) * kBlock)) {
        too_large_ = true;
        return;
      }
      r.low[axis] = static_cast<std::int64_t>(std::ceil(at - cells));
      r.high[axis] = static_cast<std::int64_t>(std::floor(at + cells));
      r.first[axis] = static_cast<float>((static_cast<double>(r.low[axis]) - at) / cells);
    }
    if (finite) add_one(r);
  }
}

void Field::add_one(const Reach& r) {
  constexpr auto kScale = static_cast<float>(kWeight * kFull);
  // Also touches the blocks of the nodes before the first ones: each cell with a node inside begins in a block.
  for (std::int64_t bz = block_of(r.low[2] - 1); bz <= block_of(r.high[2]); ++bz) {
    for (std::int64_t by = block_of(r.low[1] - 1); by <= block_of(r.high[1]); ++by) {
      for (std::int64_t bx = block_of(r.low[0] - 1); bx <= block_of(r.high[0]); ++bx) {
        NodeBlock& block = at(key_of(bx, by, bz));
        const std::int64_t x0 = std::max(r.low[0], bx * kBlock), x1 = std::min(r.high[0], bx * kBlock + kBlock - 1);
        const std::int64_t y0 = std::max(r.low[1], by * kBlock), y1 = std::min(r.high[1], by * kBlock + kBlock - 1);
        const std::int64_t z0 = std::max(r.low[2], bz * kBlock), z1 = std::min(r.high[2], bz * kBlock + kBlock - 1);
        float squares[kBlock];
        for (std::int64_t x = x0; x <= x1; ++x) {
          const float dx = r.first[0] + static_cast<float>(x - r.low[0]) * r.step;
          squares[x - x0] = dx * dx;
        }
        const auto count = static_cast<std::size_t>(std::max<std::int64_t>(x1 - x0 + 1, 0));
        for (std::int64_t z = z0; z <= z1; ++z) {
          const float dz = r.first[2] + static_cast<float>(z - r.low[2]) * r.step;
          for (std::int64_t y = y0; y <= y1; ++y) {
            const float dy = r.first[1] + static_cast<float>(y - r.low[1]) * r.step;
            const float rest = 1 - (dy * dy + dz * dz);
            if (!(rest > 0)) continue;
            std::uint32_t* row =
                block.data() + ((z - bz * kBlock) * kBlock + (y - by * kBlock)) * kBlock + (x0 - bx * kBlock);
            for (std::size_t x = 0; x < count; ++x) {
              const float s = std::max(rest - squares[x], 0.0f);
              const auto weight = static_cast<std::int32_t>(s * s * s * kScale + 0.5f);
              const std::uint32_t sum = row[x] + static_cast<std::uint32_t>(weight);
              row[x] = sum < row[x] ? kMostSum : sum;
            }
          }
        }
      }
    }
  }
}

NodeBlock& Field::at(BlockKey key) {
  if (key == last_key_) return blocks_[last_];
  const auto [found, made] = places_.try_emplace(key, blocks_.size());
  if (made) blocks_.emplace_back();
  last_key_ = key;
  last_ = found->second;
  return blocks_[last_];
}

void Field::add(const Field& other) {
  too_large_ = too_large_ || other.too_large_;
  for (const auto& [key, place] : other.places_) add_block(at(key), other.blocks_[place].data());
}

void Field::write(base::Bytes& out) const {
  out.put(static_cast<std::uint64_t>(blocks_.size()));
  for (const auto& [key, place] : places_) {
    out.put(key);
    out.put_raw(blocks_[place].data(), sizeof(NodeBlock));
  }
}

void Field::add(base::Reader& in) {
  NodeBlock block;
  for (auto left = in.get<std::uint64_t>(); left > 0; --left) {
    const auto key = in.get<BlockKey>();
    std::memcpy(block.data(), in.take(sizeof block).data(), sizeof block);
    add_block(at(key), block.data());
  }
}

std::vector<BlockKey> Field::keys() const {
  std::vector<BlockKey> keys;
  keys.reserve(places_.size());
  for (const auto& [key, place] : places_) keys.push_back(key);
  std::sort(keys.begin(), keys.end());
  return keys;
}

const NodeBlock* Field::find(BlockKey key) const {
  const auto found = places_.find(key);
  return found == places_.end() ? nullptr : &blocks_[found->second];
}

}  // namespace motes::surfaces
