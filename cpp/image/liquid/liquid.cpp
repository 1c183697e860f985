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
constexpr std::size_t kBallsAtOnce = 64;
constexpr int kSlack = 16;  // numbers beyond a plane: whole vectors are read

// The light of lit spheres.
std::shared_ptr<const SurfaceLight> light_of(const View& view) {
  Sprite sphere{SpriteKind::sphere, 0, Sprite::Blend::opaque};
  sphere.lit = true;
  return surface_light(sphere, view);
}

}  // namespace

// Calls work(y, x, count) for the rows of pixels of all tiles with some of the liquid that lie side by side.
template <class Work>
void LiquidSurface::each_run(threads::Pool& pool, const Work& work) const {
  constexpr int kTasks = kTile / kRowsAtOnce;
  pool.run(static_cast<std::size_t>(grid_.rows() * kTasks), [&](std::size_t part, std::size_t) {
    const int row = static_cast<int>(part) / kTasks * grid_.columns();
    const int first = static_cast<int>(part) * kRowsAtOnce, last = std::min(first + kRowsAtOnce, grid_.height);
    for (int from = 0, to; from < grid_.columns(); from = to + 1) {
      for (to = from; to < grid_.columns() && any(row + to);) ++to;
      const int x = from * kTile, count = std::min(to * kTile, grid_.width) - x;
      for (int y = first; y < last && from < to; ++y) work(y, x, count);
    }
  });
}

void LiquidSurface::begin(const LiquidSprite& look, const View& view) {
  look_ = look;
  focal_ = static_cast<float>(lens(view).focal_px);
  light_ = light_of(view);
  most_.assign(static_cast<std::size_t>(Grid{view.width, view.height}.tiles()), 0);
  if (grid_.width == view.width && grid_.height == view.height) return;
  grid_ = {view.width, view.height};
  const auto rows = static_cast<std::size_t>(grid_.height);
  for (auto* plane : {&depth_, &other_}) {
    plane->resize(static_cast<std::size_t>(stride()) * rows + kSlack);
    std::fill_n(plane->data(), plane->size(), kNoLiquid);
  }
  thickness_.resize(static_cast<std::size_t>(grid_.width) * rows + kSlack);
  std::fill_n(thickness_.data(), thickness_.size(), 0u);
  for (auto& plane : sums_)
    plane.assign(static_cast<std::size_t>(cell_columns()) * static_cast<std::size_t>(cell_rows()), 0);
  used_.assign(most_.size(), 0);
}

void LiquidSurface::add(const Area& area, std::span<const Piece> pieces) {
  std::uint8_t& used = used_[static_cast<std::size_t>(area.tile)];
  if (pieces.empty() && used == 0) return;
  const auto tile = std::make_unique_for_overwrite<LiquidTile>();
  tile->width = area.width;
  tile->height = area.height;
  tile->radius = look_.radius;
  std::fill_n(tile->depth, LiquidTile::kRow * area.height, kNoLiquid);
  std::fill_n(tile->thickness, LiquidTile::kRow * area.height, 0u);
  std::fill(std::begin(tile->cells), std::end(tile->cells), 0u);
  float most = 0;
  for (const Piece& piece : pieces) most = std::max(most, add(area, piece, *tile));
  most_[static_cast<std::size_t>(area.tile)] = most;
  keep(area, *tile);
  used = !pieces.empty();
}

// Adds a piece; returns the radius of its largest ball, px.
float LiquidSurface::add(const Area& area, const Piece& piece, LiquidTile& tile) const {
  const RecordForm form = piece.brush->form();
  const int bits = grid_.far_bits();
  const std::size_t bytes = piece.brush->record_bytes();
  const float first_x = 0.5f * static_cast<float>(grid_.width) - 0.5f - static_cast<float>(area.x);
  const float first_y = 0.5f * static_cast<float>(grid_.height) - 0.5f - static_cast<float>(area.y);
  float most = 0;
  LiquidBall balls[kBallsAtOnce];
  for (std::size_t i = 0, ready = 0; i < piece.count; ++i) {
    const std::byte* record = piece.records + i * bytes;
    const WideRecord r = wide_record(form, bits, record, piece.color);
    LiquidBall& ball = balls[ready++];
    // At the end of its streak: where the closing shutter finds it.
    ball.x = (static_cast<float>(r.x) + 0.5f * static_cast<float>(r.dx)) * (1.0f / 256) + first_x;
    ball.y = (static_cast<float>(r.y) + 0.5f * static_cast<float>(r.dy)) * (1.0f / 256) + first_y;
    ball.radius = static_cast<float>(size_units(r.size)) * (0.5f / (1 << kSizeBits));
    ball.depth = std::bit_cast<float>(r.depth);
    for (std::size_t c = 0; c < 3; ++c) ball.values[LiquidMean::red + c] = r.color[c];
    ball.values[LiquidMean::alpha] = r.alpha;
    ball.values[LiquidMean::speed] = look_.foam > 0 ? speed_of(record + bytes - kVelocityBytes) : 0;
    ball.values[LiquidMean::weight] = 1;
    for (int k = LiquidMean::count; k < LiquidMean::kRoom; ++k) ball.values[k] = 0;
    most = std::max(most, ball.radius);
    if (ready < kBallsAtOnce && i + 1 < piece.count) continue;
    lanes_->splat(tile, balls, ready);
    ready = 0;
  }
  return most;
}

// Returns a speed in 1/kSpeeds of that of white foam.
std::uint32_t LiquidSurface::speed_of(const std::byte* velocity) const {
  float v[3];
  std::memcpy(v, velocity, sizeof v);
  const float fast = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]) / look_.foam;
  return static_cast<std::uint32_t>(std::min(fast, kMostSpeed) * kSpeeds);
}

// Copies a tile to the picture's planes.
void LiquidSurface::keep(const Area& area, const LiquidTile& tile) {
  for (int y = 0; y < area.height; ++y) {
    std::copy_n(tile.depth + y * LiquidTile::kRow, area.width, depth_.data() + at(area.x, area.y + y));
    std::copy_n(tile.thickness + y * LiquidTile::kRow, area.width,
                thickness_.data() + static_cast<std::ptrdiff_t>(area.y + y) * grid_.width + area.x);
    // Smoothing reads both planes beyond the tiles that it writes.
    if (!any(area.tile)) std::fill_n(other_.data() + at(area.x, area.y + y), area.width, kNoLiquid);
  }
  for (int y = 0; y * kLiquidCell < area.height; ++y) {
    const auto first = static_cast<std::size_t>((area.y / kLiquidCell + y) * cell_columns() + area.x / kLiquidCell);
    const std::uint64_t* cell = tile.cells + y * kTileCells * LiquidMean::kRoom;
    for (std::size_t x = 0; static_cast<int>(x) * kLiquidCell < area.width; ++x, cell += LiquidMean::kRoom) {
      for (std::size_t k = 0; k < sums_.size(); ++k) sums_[k][first + x] = static_cast<float>(cell[k]);
    }
  }
}

bool LiquidSurface::any() const {
  return std::any_of(most_.begin(), most_.end(), [](float most) { return most > 0; });
}

// One pass of the filter, along rows or columns.
void LiquidSurface::smooth_rows(BufferOf<float>& to, const BufferOf<float>& from, int stride, bool across,
                                threads::Pool& pool) const {
  constexpr float kJump = 4;  // radii
  const float farthest = focal_ * look_.radius / static_cast<float>(stride);
  const std::vector<float> nothing(static_cast<std::size_t>(grid_.width), kNoLiquid);
  each_run(pool, [&](int y, int x, int count) {
    const float* row = from.data() + at(x, y);
    const auto other = [&](int steps) {
      const int line = y + steps * stride;
      if (across) return row + steps * stride;
      return line < 0 || line >= grid_.height ? nothing.data() : from.data() + at(x, line);
    };
    const float* const pairs[4] = {other(-1), other(1), other(-2), other(2)};
    lanes_->smooth(to.data() + at(x, y), row, pairs, kJump * look_.radius, farthest, count);
  });
}

void LiquidSurface::smooth(threads::Pool& pool) {
  const float most = *std::max_element(most_.begin(), most_.end());
  for (int stride = 1; stride <= kMostStride && static_cast<float>(stride) <= most; stride *= 2) {
    smooth_rows(other_, depth_, stride, true, pool);
    smooth_rows(depth_, other_, stride, false, pool);
  }
}

// Interpolates sums at the height of a row, in the cells around `count` pixels. `to`: those of a mean after the other,
// each for the cells of a row of the picture, and the last cell again.
void LiquidSurface::mix_sums(int y, int x, int count, float* to) const {
  const int half = 2 * y + 1 - kLiquidCell;  // from the centres of the first cells, in half px
  const int above = std::max(half, 0) / (2 * kLiquidCell), below = std::min(above + 1, cell_rows() - 1);
  const float down = std::clamp(static_cast<float>(half - 2 * kLiquidCell * above) * (0.5f / kLiquidCell), 0.0f, 1.0f);
  const int first = std::max(x / kLiquidCell - 1, 0),
            last = std::min((x + count) / kLiquidCell + 1, cell_columns() - 1);
  for (std::size_t k = 0; k < sums_.size(); ++k, to += cell_columns() + 1) {
    const float* upper = sums_[k].data() + above * cell_columns();
    const float* lower = sums_[k].data() + below * cell_columns();
    for (int cell = first; cell <= last; ++cell) to[cell] = upper[cell] * (1 - down) + lower[cell] * down;
    to[last + 1] = to[last];
  }
}

void LiquidSurface::shade(const LiquidPicture& picture, threads::Pool& pool) const {
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
  const std::vector<float> nothing(static_cast<std::size_t>(grid_.width + 2 * kPad), kNoLiquid);
  each_run(pool, [&](int y, int x, int count) {
    const int cells = cell_columns();
    std::vector<float> sums(sums_.size() * static_cast<std::size_t>(cells + 1));
    mix_sums(y, x, count, sums.data());
    const auto line = [&](int row) {
      return row < 0 || row >= grid_.height ? nothing.data() + kPad : depth_.data() + at(x, row);
    };
    const std::ptrdiff_t pixel = static_cast<std::ptrdiff_t>(y) * grid_.width + x;
    LiquidRow row{line(y),
                  line(y - 1),
                  line(y + 1),
                  picture.depth + y * picture.row + x,
                  thickness_.data() + pixel,
                  {},
                  cells,
                  picture.light + 3 * pixel,
                  y,
                  x,
                  count};
    for (std::size_t k = 0; k < sums_.size(); ++k) row.sums[k] = sums.data() + k * static_cast<std::size_t>(cells + 1);
    lanes_->shade(look, row);
  });
}

}  // namespace motes::image
