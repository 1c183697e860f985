#include "image/liquid/liquids.h"

#include <algorithm>
#include <iterator>
#include <tuple>
#include <utility>

namespace motes::image {

bool Liquids::begin(const View& view, const Pieces& pieces) {
  grid_ = {view.width, view.height};
  std::vector<LiquidSprite> looks;
  pieces.each_brush([&](const Brush& brush) {
    if (const auto* look = brush.sprite().as<LiquidSprite>()) looks.push_back(*look);
  });
  const auto key = [](const LiquidSprite& look) { return std::tuple(look.radius, look.foam, look.glass); };
  std::sort(looks.begin(), looks.end(), [&](const auto& a, const auto& b) { return key(a) < key(b); });
  looks.erase(std::unique(looks.begin(), looks.end()), looks.end());
  count_ = looks.size();
  if (count_ == 0) return false;
  while (liquids_.size() < count_) liquids_.emplace_back();
  for (std::size_t i = 0; i < count_; ++i) liquids_[i].begin(looks[i], view);
  const auto pixels = static_cast<std::size_t>(grid_.width) * static_cast<std::size_t>(grid_.height);
  depth_.resize(static_cast<std::size_t>(row()) * static_cast<std::size_t>(grid_.height));
  behind_.resize(3 * pixels);
  shown_.assign(pixels, 0);
  near_.assign(static_cast<std::size_t>(grid_.tiles()), 0);
  fronts_.clear();
  fronts_.resize(static_cast<std::size_t>(grid_.tiles()));
  return true;
}

void Liquids::add(const Area& area, std::span<const Piece> pieces) {
  std::vector<Piece> own;
  for (std::size_t i = 0; i < count_; ++i) {
    own.clear();
    std::copy_if(pieces.begin(), pieces.end(), std::back_inserter(own), [&](const Piece& piece) {
      const auto* look = piece.brush->sprite().as<LiquidSprite>();
      return look != nullptr && *look == liquids_[i].look();
    });
    liquids_[i].add(area, own);
  }
}

void Liquids::added() {
  const int reach = static_cast<int>(kMostShift * static_cast<float>(grid_.height)) + 2;  // of pixels that look behind
  const auto tiles = [](int px) { return px >> kTileBits; };
  for (int tile = 0; tile < grid_.tiles(); ++tile) {
    if (!any(tile)) continue;
    const Area area = grid_.area(tile);
    const int top = tiles(std::max(area.y - reach, 0)), left = tiles(std::max(area.x - reach, 0));
    const int bottom = tiles(std::min(area.y + area.height + reach, grid_.height) - 1);
    const int right = tiles(std::min(area.x + area.width + reach, grid_.width) - 1);
    for (int y = top; y <= bottom; ++y)
      std::fill_n(near_.begin() + y * grid_.columns() + left, right - left + 1, std::uint8_t{1});
  }
}

bool Liquids::any(int tile) const {
  return std::any_of(liquids_.begin(), liquids_.begin() + static_cast<std::ptrdiff_t>(count_),
                     [&](const LiquidSurface& one) { return one.any(tile); });
}

void Liquids::take(const TilePainter& painter, std::uint32_t* light, std::size_t row_lanes) {
  const TileLight from = painter.light();
  from.copy_to(light, row_lanes);
  painter.depth(depth_.data() + from.y * row() + from.x, static_cast<std::size_t>(row()));
}

void Liquids::keep_front(const Area& area, std::span<const Piece> others, TilePainter& painter) {
  std::vector<Piece> blended;
  std::copy_if(others.begin(), others.end(), std::back_inserter(blended),
               [](const Piece& piece) { return !piece.brush->blends(Sprite::Blend::opaque); });
  if (blended.empty() || !any(area.tile)) return;
  std::vector<float> nearest(std::size_t{kTile} * kTile, kNoLiquid);
  for (std::size_t i = 0; i < count_; ++i) {
    for (int y = 0; y < area.height; ++y) {
      const float* row = liquids_[i].depth(area.y + y) + area.x;
      for (int x = 0; x < area.width; ++x) {
        float& least = nearest[static_cast<std::size_t>(y * kTile + x)];
        least = std::min(least, row[x]);
      }
    }
  }
  auto front = std::make_unique<Front>();
  const auto row = static_cast<std::size_t>(3 * area.width);
  for (auto* plane : {&front->light, &front->passed}) {
    plane->resize(row * static_cast<std::size_t>(area.height));
    painter.front(blended, nearest.data(), kTile, plane == &front->passed);
    painter.light().copy_to(plane->data(), row);
  }
  fronts_[static_cast<std::size_t>(area.tile)] = std::move(front);
}

// Calls work(first sum of the pixel in the picture, in the tile, front) for the pixels with a liquid and something in
// front of it.
template <class Work>
void Liquids::each_front_pixel(const Work& work) const {
  for (int tile = 0; tile < grid_.tiles(); ++tile) {
    const Front* front = fronts_[static_cast<std::size_t>(tile)].get();
    if (front == nullptr) continue;
    const Area area = grid_.area(tile);
    std::size_t own = 0;
    for (int y = area.y; y < area.y + area.height; ++y) {
      for (int x = area.x; x < area.x + area.width; ++x, own += 3) {
        const auto pixel =
            static_cast<std::size_t>(y) * static_cast<std::size_t>(grid_.width) + static_cast<std::size_t>(x);
        work(x, y, pixel, own, *front);
      }
    }
  }
}

// Takes what is in front of liquids from the light there: it was front + passed * behind.
void Liquids::take_away_front(std::uint32_t* behind) const {
  each_front_pixel([&](int x, int y, std::size_t pixel, std::size_t own, const Front& front) {
    const bool liquid = std::any_of(liquids_.begin(), liquids_.begin() + static_cast<std::ptrdiff_t>(count_),
                                    [&](const LiquidSurface& one) { return one.depth(y)[x] < kNoLiquid / 2; });
    if (!liquid) return;
    for (std::size_t c = 0; c < 3; ++c) {
      std::uint32_t& sum = behind[3 * pixel + c];
      const std::uint64_t passed = front.passed[own + c], light = front.light[own + c];
      const std::uint64_t rest = sum > light ? sum - light : 0;
      sum = passed == 0 ? 0 : static_cast<std::uint32_t>(std::min<std::uint64_t>(rest * kUnit / passed, 0xffffffffu));
    }
  });
}

void Liquids::add_front(std::uint32_t* light) const {
  each_front_pixel([&](int, int, std::size_t pixel, std::size_t own, const Front& front) {
    if (shown_[pixel] == 0) return;
    for (std::size_t c = 0; c < 3; ++c) {
      std::uint32_t& sum = light[3 * pixel + c];
      const std::uint64_t passed = std::uint64_t{sum} * front.passed[own + c] / kUnit;
      sum = static_cast<std::uint32_t>(std::min<std::uint64_t>(passed + front.light[own + c], 0xffffffffu));
    }
  });
}

// Calls work(area) for all tiles near a liquid.
template <class Work>
void Liquids::each_near(threads::Pool& pool, const Work& work) const {
  pool.run(near_.size(), [&](std::size_t tile, std::size_t) {
    if (near_[tile] != 0) work(grid_.area(static_cast<int>(tile)));
  });
}

void Liquids::finish(std::uint32_t* light, threads::Pool& pool) {
  bool first_liquid = true;
  for (std::size_t i = 0; i < count_; ++i) {
    if (!liquids_[i].any()) continue;
    each_near(pool, [&](const Area& area) {
      for (int y = area.y; y < area.y + area.height; ++y) {
        const std::size_t first = 3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(grid_.width) +
                                       static_cast<std::size_t>(area.x));
        std::copy_n(light + first, 3 * area.width, behind_.data() + first);
      }
    });
    if (std::exchange(first_liquid, false)) take_away_front(behind_.data());
    liquids_[i].smooth(pool);
    liquids_[i].shade({light, behind_.data(), depth_.data(), row()}, pool);
    each_near(pool, [&](const Area& area) { show(liquids_[i], area); });
  }
  add_front(light);
}

// Notes where a liquid is in front of everything else.
void Liquids::show(const LiquidSurface& liquid, const Area& area) {
  if (!liquid.any(area.tile)) return;
  for (int y = area.y; y < area.y + area.height; ++y) {
    const float* own = liquid.depth(y) + area.x;
    float* nearest = depth_.data() + y * row() + area.x;
    std::uint8_t* shown = shown_.data() + static_cast<std::ptrdiff_t>(y) * grid_.width + area.x;
    for (int x = 0; x < area.width; ++x) {
      const bool visible = own[x] < kNoLiquid / 2 && own[x] <= nearest[x];
      nearest[x] = visible ? own[x] : nearest[x];
      shown[x] = visible ? 1 : shown[x];
    }
  }
}

}  // namespace motes::image
