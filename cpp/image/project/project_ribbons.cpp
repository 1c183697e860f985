#include "image/project/project_ribbons.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "base/vectors.h"
#include "image/grid.h"
#include "image/moments.h"
#include "image/ribbon_spline.h"

namespace motes::image {
namespace {

constexpr double kRibbonEdge = 65536;  // distance from the middle of the picture at which ribbons end, px
constexpr float kMostMoved = 2047;   // greatest motion while the shutter is open, px

std::uint32_t byte_of(float v) { return v > 0 ? static_cast<std::uint32_t>(std::min(v, 1.0f) * 255 + 0.5f) : 0; }

struct PlaceInView {
  double x = 0, y = 0, depth = 0;
  bool in_front = false;
};

PlaceInView place_in_view(const Lens& lens, const Vector& place, double near) {
  const Vector offset = place - lens.eye;
  PlaceInView seen;
  seen.depth = dot(offset, lens.forward);
  if (!(seen.depth >= near)) return seen;
  const double scale = lens.focal_px / seen.depth;
  seen.x = dot(offset, lens.right) * scale;
  seen.y = -dot(offset, lens.up) * scale;
  seen.in_front = std::abs(seen.x) <= kRibbonEdge && std::abs(seen.y) <= kRibbonEdge;
  return seen;
}

// Projects one system's ribbons to records.
class RibbonMaker {
 public:
  RibbonMaker(const Drawn& particles, const Sprite& sprite, const View& view, double open, const RibbonLight& light,
              std::size_t first)
      : d_(particles), ribbon_(*sprite.as<RibbonSprite>()), adds_(sprite.blend == Sprite::Blend::add), view_(view),
        light_(light), first_(first), grid_{view.width, view.height}, now_(lens(view)), then_(lens_at_opening(view)),
        open_(static_cast<float>(open)), blur_(static_cast<float>(0.5 * blur_of(view))) {}

  // Returns false if the ribbon is invisible.
  bool make(std::size_t i, RibbonRecord& r) {
    r = {};
    r.width = ribbon_.width;
    r.size = kMaxDiameter << kSizeBits;
    r.light = kAllLight;
    add_points(i, r);
    return r.count != 0 && set_colors(i, r);
  }

  // Lists the tiles that the record touches.
  const std::vector<std::uint32_t>& tiles(const RibbonRecord& r) {
    tiles_.clear();
    RibbonRecord then = r;  // as it was when the shutter opened
    for (RibbonPoint& p : then.point) {
      p.x += static_cast<float>(p.then_x) * (1.0f / 16);
      p.y += static_cast<float>(p.then_y) * (1.0f / 16);
    }
    for (std::uint32_t k = 0; k + 1 < r.count || k == 0; ++k) {
      Box box(r.point[k], reach(r, r.point[k]));
      box.add(then.point[k], box.reach);
      if (r.count > 1) {
        const float reaches = std::max(reach(r, r.point[k]), reach(r, r.point[k + 1]));
        for (const RibbonRecord* one : {&r, static_cast<const RibbonRecord*>(&then)}) {
          const RibbonSpan hull = ribbon_span(*one, static_cast<int>(k));
          for (const OnScreen& at : {hull.from, hull.leaving, hull.arriving, hull.to}) box.add(at, reaches);
        }
      }
      add_tiles(box);
    }
    std::sort(tiles_.begin(), tiles_.end());
    tiles_.erase(std::unique(tiles_.begin(), tiles_.end()), tiles_.end());
    return tiles_;
  }

 private:
  // Projects the positions from the particle backwards, until one is behind the camera.
  void add_points(std::size_t i, RibbonRecord& r) {
    const std::size_t kept = kept_of(i);
    const float oldest = kept > 0 ? d_.past[kept - 1].age : 0, reach = std::min(ribbon_.length, oldest);
    const float run = reach > 0 ? std::min(open_ / reach, kMostRun) : 0;
    r.up_y = static_cast<std::int16_t>(run * (1 / kRunUnit) + 0.5f);
    if (!add_point(i, 0, d_.position, 0, r)) return finish(r);
    for (std::size_t k = 0; k < kept; ++k) {
      const Past& past = d_.past[k];
      if (!(past.age > 0) || past.position[0] == nullptr) continue;  // age 0: the particle itself
      const float along = past.age / reach;
      if (!add_point(i, k + 1, past.position, along, r) || along >= 1) break;
    }
    finish(r);
  }

  std::size_t kept_of(std::size_t i) const {
    const float kept = d_.past_count == nullptr ? 0 : d_.past_count[i];
    return kept >= 1 ? static_cast<std::size_t>(std::min(kept, static_cast<float>(kMostPast))) : 0;
  }

  // Returns false for a position behind the camera.
  bool add_point(std::size_t i, std::size_t place, const std::array<const float*, 3>& planes, float along,
                 RibbonRecord& r) {
    const Vector at{planes[0][i], planes[1][i], planes[2][i]};
    const PlaceInView seen = place_in_view(now_, at, view_.camera.near);
    if (!seen.in_front) return r.count == 0 && place != 0;
    RibbonPoint& p = r.point[r.count];
    p.x = static_cast<float>(seen.x);
    p.y = static_cast<float>(seen.y);
    p.depth = static_cast<float>(seen.depth);
    p.along = along;
    const PlaceInView before = view_.shutter > 0 ? place_in_view(then_, at, view_.camera.near) : PlaceInView{};
    if (before.in_front) {
      p.then_x = sixteenths(before.x - seen.x);
      p.then_y = sixteenths(before.y - seen.y);
    }
    places_[r.count++] = place;
    return true;
  }

  static std::int16_t sixteenths(double way) {
    return static_cast<std::int16_t>(
        std::floor(std::clamp(static_cast<float>(way), -kMostMoved, kMostMoved) * 16 + 0.5f));
  }

  // Sets the record's nearest depth, and its position: that of the first point.
  static void finish(RibbonRecord& r) {
    if (r.count == 0) return;
    float least = r.point[0].depth;
    for (std::uint32_t k = 1; k < r.count; ++k) least = std::min(least, r.point[k].depth);
    std::memcpy(&r.depth, &least, sizeof least);
    r.x = static_cast<std::int32_t>(std::floor(r.point[0].x * (1 << kWideBits)));
    r.y = static_cast<std::int32_t>(std::floor(r.point[0].y * (1 << kWideBits)));
  }

  float channel(std::size_t i, std::size_t place, std::size_t c) const {
    if (light_.planes != nullptr) return light_.at(place, c, i - first_);
    return d_.color[c] != nullptr ? d_.color[c][i] : d_.color_of_all[c];
  }

  // Sets the record's colour to the maximum of each channel, and the points' to fractions of it. Returns false if all
  // are invisible.
  bool set_colors(std::size_t i, RibbonRecord& r) const {
    std::array<float, 3> most{};
    for (std::uint32_t k = 0; k < r.count; ++k) {
      for (std::size_t c = 0; c < 3; ++c) most[c] = std::max(most[c], std::min(channel(i, places_[k], c), 1e15f));
    }
    for (std::uint32_t k = 0; k < r.count; ++k) {
      for (std::size_t c = 0; c < 3; ++c) {
        const float part = most[c] > 0 ? channel(i, places_[k], c) / most[c] : 1;
        r.point[k].tint[c] = static_cast<std::uint8_t>(byte_of(part));
      }
    }
    float alpha = d_.alpha != nullptr ? d_.alpha[i] : d_.alpha_of_all;
    if (adds_) share_light(most, alpha);
    for (std::size_t c = 0; c < 3; ++c) r.color[c] = static_cast<std::uint8_t>(byte_of(most[c]));
    r.alpha = static_cast<std::uint8_t>(byte_of(alpha));
    return r.alpha != 0 && (!adds_ || r.color[0] != 0 || r.color[1] != 0 || r.color[2] != 0);
  }

  // Splits light into colour and alpha as for other sprites: a colour above 1 is scaled into alpha; where all are
  // faint, both get about the root of the largest.
  static void share_light(std::array<float, 3>& color, float& alpha) {
    const float opacity = alpha > 0 ? std::min(alpha, 1.0f) : 0;
    std::array<float, 3> light;
    for (std::size_t c = 0; c < 3; ++c) light[c] = std::min(color[c] * opacity, 1.0f);
    const float most = *std::max_element(light.begin(), light.end());
    const bool faint = most < 1.0f / 16;
    if (!(most > 0) || (!faint && *std::max_element(color.begin(), color.end()) <= 1)) return;
    const float part = faint ? std::ceil(std::sqrt(most) * 255) : std::floor(most * 255 + 0.5f);
    for (std::size_t c = 0; c < 3; ++c) color[c] = light[c] * (255 / part);
    alpha = part / 255;
  }

  // Returns how far from its line a ribbon may touch pixels at a point, px.
  float reach(const RibbonRecord& r, const RibbonPoint& p) const {
    const float along = std::min(p.along, 1.0f);
    const float half = ribbon_half(r.width * static_cast<float>(now_.focal_px), 1 / p.depth, along);
    const float spread = spread_at(blur_, static_cast<float>(view_.camera.focus), 1 / p.depth);
    return half + 2 + 1.25f * std::min(std::abs(spread), kMostPosedReach) + (blur_ > 0 ? 2.0f : 0.0f);
  }

  // The bounding box on the screen, px from the picture's middle.
  struct Box {
    float left, right, above, below, reach;

    Box(const RibbonPoint& p, float wide)
        : left(p.x - wide), right(p.x + wide), above(p.y - wide), below(p.y + wide), reach(wide) {}
    template <class Place>
    void add(const Place& at, float wide) {
      left = std::min(left, at.x - wide);
      right = std::max(right, at.x + wide);
      above = std::min(above, at.y - wide);
      below = std::max(below, at.y + wide);
    }
  };

  void add_tiles(const Box& box) {
    const int columns = grid_.columns(), rows = grid_.rows();
    const auto tile = [](float at, int pixels, int end) {
      const float number = std::floor((at + 0.5f * static_cast<float>(pixels)) / kTile);
      return static_cast<int>(std::clamp(number, -1.0f, static_cast<float>(end)));
    };
    const int last_column = std::min(tile(box.right, grid_.width, columns), columns - 1);
    const int last_row = std::min(tile(box.below, grid_.height, rows), rows - 1);
    for (int row = std::max(tile(box.above, grid_.height, rows), 0); row <= last_row; ++row) {
      for (int column = std::max(tile(box.left, grid_.width, columns), 0); column <= last_column; ++column) {
        tiles_.push_back(static_cast<std::uint32_t>(row * columns + column));
      }
    }
  }

  const Drawn& d_;
  const RibbonSprite& ribbon_;
  bool adds_;
  const View& view_;
  const RibbonLight& light_;
  std::size_t first_;
  Grid grid_;
  Lens now_, then_;
  float open_;  // exposure time, s
  float blur_;  // blur radius at infinity, px
  std::array<std::size_t, kMostPast + 1> places_{};  // of the record's points
  std::vector<std::uint32_t> tiles_;
};

}  // namespace

void project_ribbons(const Drawn& particles, const Sprite& sprite, const View& view, double open,
                     const RibbonLight& light, std::size_t first, std::size_t last, RibbonBatch& batch) {
  batch.records.clear();
  batch.particles.clear();
  batch.tiles.clear();
  RibbonMaker maker(particles, sprite, view, open, light, first);
  RibbonRecord record;
  for (std::size_t i = first; i < last; ++i) {
    if (!maker.make(i, record)) continue;
    const std::vector<std::uint32_t>& tiles = maker.tiles(record);
    if (tiles.empty()) continue;
    for (const std::uint32_t tile : tiles)
      batch.tiles.push_back({static_cast<std::uint32_t>(batch.records.size()), tile});
    batch.records.push_back(record);
    batch.particles.push_back(i);
  }
}

}  // namespace motes::image
