#include "image/liquid/liquid.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "image/camera.h"
#include "image/layout.h"

namespace motes::image {
namespace {

constexpr int kRowsAtOnce = 8;  // of a task
constexpr float kSpeeds = 256;  // units of speeds per speed of white foam
constexpr float kMostSpeed = 4;  // in speeds of white foam
constexpr int kSlack = 16;  // numbers beyond a plane: whole vectors are read

// The light of lit spheres.
std::shared_ptr<const SurfaceLight> light_of(const View& view) {
  Sprite sphere{SpriteKind::sphere, 0, Sprite::Blend::opaque};
  sphere.lit = true;
  return surface_light(sphere, view);
}

// Calls work(y) for the rows of an area.
template <class Work>
void each_row(threads::Pool& pool, const Area& box, const Work& work) {
  pool.run(static_cast<std::size_t>((box.height + kRowsAtOnce - 1) / kRowsAtOnce), [&](std::size_t part, std::size_t) {
    const int first = box.y + static_cast<int>(part) * kRowsAtOnce;
    for (int y = first; y < std::min(first + kRowsAtOnce, box.y + box.height); ++y) work(y);
  });
}

}  // namespace

// A particle: its centre, px from the tile's first pixel, and what it adds.
struct LiquidSurface::Ball {
  float x, y, radius, depth;
  std::uint64_t values[speed + 1];
};

void LiquidSurface::begin(const LiquidSprite& look, const View& view) {
  look_ = look;
  grid_ = {view.width, view.height};
  focal_ = static_cast<float>(lens(view).focal_px);
  light_ = light_of(view);
  const auto rows = static_cast<std::size_t>(grid_.height);
  const auto numbers = static_cast<std::size_t>(stride()) * rows;
  depth_.resize(numbers + kSlack);
  other_.resize(numbers + kSlack);
  thickness_.resize(static_cast<std::size_t>(grid_.width) * rows + kSlack);
  std::fill_n(thickness_.data() + thickness_.size() - kSlack, kSlack, 0u);
  for (auto* plane : {&depth_, &other_}) {  // between rows; clear() fills the rows
    std::fill_n(plane->data(), kPad, kNoLiquid);
    for (int y = 1; y < grid_.height; ++y) std::fill_n(plane->data() + at(-2 * kPad, y), 2 * kPad, kNoLiquid);
    std::fill_n(plane->data() + at(grid_.width, grid_.height - 1), kPad + kSlack, kNoLiquid);
  }
  for (auto& plane : cells_)
    plane.resize(static_cast<std::size_t>(cell_columns()) * static_cast<std::size_t>(cell_rows()));
  most_.assign(static_cast<std::size_t>(grid_.tiles()), 0);
}

void LiquidSurface::clear(const Area& area) {
  for (int y = area.y; y < area.y + area.height; ++y) {
    std::fill_n(depth_.data() + at(area.x, y), area.width, kNoLiquid);
    std::fill_n(thickness_.data() + static_cast<std::ptrdiff_t>(y) * grid_.width + area.x, area.width, 0u);
  }
  for (int y = area.y / kCell; y * kCell < area.y + area.height; ++y) {
    const std::ptrdiff_t first = static_cast<std::ptrdiff_t>(y) * cell_columns() + area.x / kCell;
    for (auto& plane : cells_) std::fill_n(plane.data() + first, (area.width + kCell - 1) / kCell, std::uint64_t{0});
  }
}

void LiquidSurface::add(const Area& area, const Piece& piece) {
  const RecordForm form = piece.brush->form();
  const int bits = grid_.far_bits();
  const std::size_t bytes = piece.brush->record_bytes();
  const float first_x = 0.5f * static_cast<float>(grid_.width) - 0.5f - static_cast<float>(area.x);
  const float first_y = 0.5f * static_cast<float>(grid_.height) - 0.5f - static_cast<float>(area.y);
  for (std::size_t i = 0; i < piece.count; ++i) {
    const std::byte* record = piece.records + i * bytes;
    const WideRecord r = wide_record(form, bits, record, piece.color);
    Ball ball{};
    // At the end of its streak: where the closing shutter finds it.
    ball.x = (static_cast<float>(r.x) + 0.5f * static_cast<float>(r.dx)) * (1.0f / 256) + first_x;
    ball.y = (static_cast<float>(r.y) + 0.5f * static_cast<float>(r.dy)) * (1.0f / 256) + first_y;
    ball.radius = static_cast<float>(size_units(r.size)) * (0.5f / (1 << kSizeBits));
    ball.depth = std::bit_cast<float>(r.depth);
    for (std::size_t c = 0; c < 3; ++c) ball.values[c] = r.color[c];
    ball.values[alpha] = r.alpha;
    if (look_.foam > 0) {
      float v[3];
      std::memcpy(v, record + bytes - kVelocityBytes, sizeof v);
      const float fast = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]) / look_.foam;
      ball.values[speed] = static_cast<std::uint64_t>(std::min(fast, kMostSpeed) * kSpeeds);
    }
    add_ball(area, ball);
  }
}

void LiquidSurface::add_ball(const Area& area, const Ball& ball) {
  const int first = std::max(0, static_cast<int>(std::ceil(ball.y - ball.radius)));
  const int last = std::min(area.height - 1, static_cast<int>(std::floor(ball.y + ball.radius)));
  BallRow row{0, 1 / ball.radius, 0, ball.depth, look_.radius};
  bool touched = false;
  for (int y = first; y <= last; ++y) {
    const float down = (static_cast<float>(y) - ball.y) * row.per_px;
    row.rest = 1 - down * down;
    if (!(row.rest > 0)) continue;
    const float half = std::sqrt(row.rest) * ball.radius;
    const int from = std::max(0, static_cast<int>(std::ceil(ball.x - half)));
    const int to = std::min(area.width - 1, static_cast<int>(std::floor(ball.x + half)));
    if (from > to) continue;
    touched = true;
    row.x = ball.x - static_cast<float>(from);
    lanes_->splat(row, depth_.data() + at(area.x + from, area.y + y),
                  thickness_.data() + static_cast<std::ptrdiff_t>(area.y + y) * grid_.width + area.x + from,
                  to - from + 1);
  }
  if (!touched) return;
  float& most = most_[static_cast<std::size_t>(area.tile)];
  most = std::max(most, ball.radius);
  add_means(area, ball);
}

// Adds to the cells that the ball touches, the more the nearer they are to its centre.
void LiquidSurface::add_means(const Area& area, const Ball& ball) {
  const auto cell = [](float px) { return static_cast<int>(std::floor((px + 0.5f) * (1.0f / kCell))); };
  const int columns = (area.width + kCell - 1) / kCell, rows = (area.height + kCell - 1) / kCell;
  const int x0 = std::max(0, cell(ball.x - ball.radius)), x1 = std::min(columns - 1, cell(ball.x + ball.radius));
  const int y0 = std::max(0, cell(ball.y - ball.radius)), y1 = std::min(rows - 1, cell(ball.y + ball.radius));
  const float per_px = 1 / ball.radius;
  const auto beyond = [&](float center, int at) {
    const float low = static_cast<float>(at * kCell) - 0.5f;
    return (center - std::clamp(center, low, low + kCell)) * per_px;
  };
  for (int y = y0; y <= y1; ++y) {
    const float down = beyond(ball.y, y);
    for (int x = x0; x <= x1; ++x) {
      const float across = beyond(ball.x, x), rest = 1 - (across * across + down * down);
      if (!(rest > 0)) continue;
      const auto part = static_cast<std::uint64_t>(rest * rest * 255 + 1);
      const auto to = static_cast<std::size_t>((area.y / kCell + y) * cell_columns() + area.x / kCell + x);
      for (int k = red; k <= speed; ++k) cells_[k].data()[to] += part * ball.values[k];
      cells_[weight].data()[to] += part;
    }
  }
}

bool LiquidSurface::any() const {
  return std::any_of(most_.begin(), most_.end(), [](float most) { return most > 0; });
}

Area LiquidSurface::box() const {
  int left = grid_.width, right = 0, top = grid_.height, bottom = 0;
  for (int tile = 0; tile < grid_.tiles(); ++tile) {
    if (!any(tile)) continue;
    const Area area = grid_.area(tile);
    left = std::min(left, area.x);
    right = std::max(right, area.x + area.width);
    top = std::min(top, area.y);
    bottom = std::max(bottom, area.y + area.height);
  }
  return {0, left, top, right - left, bottom - top};
}

// One pass of the filter over the box, along rows or columns.
void LiquidSurface::smooth_rows(BufferOf<float>& to, const BufferOf<float>& from, int stride, bool across,
                                threads::Pool& pool) const {
  constexpr float kJump = 4;  // radii
  const Area area = box();
  const float farthest = focal_ * look_.radius / static_cast<float>(stride);
  const std::vector<float> nothing(static_cast<std::size_t>(area.width), kNoLiquid);
  each_row(pool, area, [&](int y) {
    const float* row = from.data() + at(area.x, y);
    const auto other = [&](int steps) {
      const int line = y + steps * stride;
      if (across) return row + steps * stride;
      return line < area.y || line >= area.y + area.height ? nothing.data() : from.data() + at(area.x, line);
    };
    const float* const pairs[4] = {other(-1), other(1), other(-2), other(2)};
    lanes_->smooth(to.data() + at(area.x, y), row, pairs, kJump * look_.radius, farthest, area.width);
  });
}

void LiquidSurface::smooth(threads::Pool& pool) {
  const float most = *std::max_element(most_.begin(), most_.end());
  for (int stride = 1; stride <= kMostStride && static_cast<float>(stride) <= most; stride *= 2) {
    smooth_rows(other_, depth_, stride, true, pool);
    smooth_rows(depth_, other_, stride, false, pool);
  }
}

// Interpolates the means of a row of pixels between the centres of cells. `to`: `means` rows of the box's pixels.
void LiquidSurface::spread_means(int y, const Area& box, float* to, std::ptrdiff_t stride) const {
  const auto cell_of = [](int px, int cells, int& from, int& next) {
    const int half = 2 * px + 1 - kCell;  // from the centre of the first cell, in half px
    from = std::clamp(half < 0 ? 0 : half / (2 * kCell), 0, cells - 1);
    next = std::min(from + 1, cells - 1);
    return std::clamp(static_cast<float>(half - 2 * kCell * from) * (0.5f / kCell), 0.0f, 1.0f);
  };
  int above, below;
  const float down = cell_of(y, cell_rows(), above, below);
  for (int x = box.x; x < box.x + box.width; ++x) {
    int left, right;
    const float along = cell_of(x, cell_columns(), left, right);
    float found[means];
    for (int k = 0; k < means; ++k) {
      const auto value = [&](int line, int column) {
        return static_cast<float>(cells_[k].data()[line * cell_columns() + column]);
      };
      const float first = value(above, left) * (1 - along) + value(above, right) * along;
      const float second = value(below, left) * (1 - along) + value(below, right) * along;
      found[k] = first * (1 - down) + second * down;
    }
    const float part = found[weight] > 0 ? 1 / (found[weight] * 255) : 0;
    for (int k = 0; k < weight; ++k) to[k * stride + x - box.x] = found[k] * part;
  }
}

void LiquidSurface::shade(const LiquidPicture& picture, threads::Pool& pool) const {
  const Area area = box();
  LiquidLook look{};
  look.light = light_.get();
  look.per_px = 1 / focal_;
  look.center_x = 0.5f * static_cast<float>(grid_.width);
  look.center_y = 0.5f * static_cast<float>(grid_.height);
  look.metres = 2 * look_.radius / kThickness;
  look.radius = look_.radius;
  look.bend = 1 - 1 / look_.glass;
  const float reflected = (look_.glass - 1) / (look_.glass + 1);
  look.reflected = reflected * reflected;
  look.per_foam = look_.foam > 0 ? 255 / kSpeeds : 0;
  look.behind = picture.behind;
  look.opaque = picture.depth;
  look.opaque_row = picture.row;
  look.width = grid_.width;
  look.height = grid_.height;
  const std::ptrdiff_t stride = area.width + kSlack;
  const std::vector<float> nothing(static_cast<std::size_t>(grid_.width + 2 * kPad), kNoLiquid);
  each_row(pool, area, [&](int y) {
    std::vector<float> mean(static_cast<std::size_t>(stride) * means);
    spread_means(y, area, mean.data(), stride);
    const auto line = [&](int row) {
      return row < 0 || row >= grid_.height ? nothing.data() + kPad : depth_.data() + at(area.x, row);
    };
    const std::ptrdiff_t pixel = static_cast<std::ptrdiff_t>(y) * grid_.width + area.x;
    lanes_->shade(
        look, {line(y), line(y - 1), line(y + 1), picture.depth + y * picture.row + area.x, thickness_.data() + pixel,
               mean.data(), mean.data() + stride, mean.data() + 2 * stride, mean.data() + alpha * stride,
               mean.data() + speed * stride, picture.light + 3 * pixel, y, area.x, area.width});
  });
}

}  // namespace motes::image
