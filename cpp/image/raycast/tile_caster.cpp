#include "image/raycast/tile_caster.h"

#include <algorithm>
#include <array>
#include <limits>

namespace motes::image {
namespace {

constexpr std::size_t kVector = 16;  // greatest number of lanes of any build
constexpr int kBordered = kSurfaceStride;
constexpr std::size_t kCenters = static_cast<std::size_t>(kBordered) * kBordered;
constexpr std::size_t kPixels = static_cast<std::size_t>(kTile) * kTile;
constexpr std::size_t kBorder = 4 * static_cast<std::size_t>(kTile);

// Samples are on a rotated grid, so nearly vertical or horizontal edges have four steps.
constexpr std::size_t kSamples = 4;
constexpr std::array<float, kSamples> kSampleX = {0.375f, 0.875f, 0.625f, 0.125f};
constexpr std::array<float, kSamples> kSampleY = {0.125f, 0.375f, 0.875f, 0.625f};

constexpr std::size_t bordered(int x, int y) { return static_cast<std::size_t>((y + 1) * kBordered + x + 1); }
constexpr std::size_t bordered(std::uint32_t pixel) {
  return bordered(static_cast<int>(pixel % kTile), static_cast<int>(pixel / kTile));
}

// Position of an adjacent pixel in the tile's coordinates: kTile of them above, then below, left, right.
struct Place {
  int x, y;
};
Place border_place(const TilePart& part, int i) {
  const int along = i % kTile;
  switch (i / kTile) {
    case 0: return {std::min(along, part.width - 1), -1};
    case 1: return {std::min(along, part.width - 1), part.height};
    case 2: return {-1, std::min(along, part.height - 1)};
    default: return {part.width, std::min(along, part.height - 1)};
  }
}

bool any_mesh(const CastSolid* solids, std::size_t count) {
  return std::any_of(solids, solids + count, [](const CastSolid& solid) { return solid.nodes != nullptr; });
}

bool any_shadow_of_a_mesh(const ShadeView& view) {
  return any_mesh(view.cast.solids, view.sun.shines ? view.cast.count : 0) ||
         std::any_of(view.lights, view.lights + view.light_count,
                     [](const CastLight& light) { return any_mesh(light.solids, light.count); });
}

// Returns all pixels in blocks of 4x4: rays of one vector that are close together traverse fewer boxes of a mesh.
const std::array<std::uint32_t, kPixels>& blocks() {
  static const auto all = [] {
    constexpr std::uint32_t kBlock = 4, kSide = kTile / kBlock;
    std::array<std::uint32_t, kPixels> pixels{};
    for (std::uint32_t i = 0; i < kPixels; ++i) {
      const std::uint32_t block = i / (kBlock * kBlock), y = i / kBlock % kBlock, x = i % kBlock;
      pixels[i] = (block / kSide * kBlock + y) * kTile + block % kSide * kBlock + x;
    }
    return pixels;
  }();
  return all;
}

void copy(const Surfaces& from, std::size_t i, const Surfaces& to, std::size_t k) {
  to.distance[k] = from.distance[i];
  for (std::size_t axis = 0; axis < 3; ++axis) to.normal[axis][k] = from.normal[axis][i];
  to.surface[k] = from.surface[i];
  if (to.triangle != nullptr) to.triangle[k] = from.triangle[i];
}

}  // namespace

void SurfaceList::resize(std::size_t count, bool triangles) {
  count_ = count;
  triangles_ = triangles;
  stride_ = (count + 2 * kVector) / kVector * kVector;
  planes_.resize((triangles ? 6 : 5) * stride_);
}

Surfaces SurfaceList::from(std::size_t first) {
  float* const start = planes_.data() + first;
  return {start,
          {start + stride_, start + 2 * stride_, start + 3 * stride_},
          reinterpret_cast<std::uint32_t*>(start + 4 * stride_),
          triangles_ ? reinterpret_cast<std::uint32_t*>(start + 5 * stride_) : nullptr};
}

void TileCaster::reserve_points(std::size_t count) {
  for (std::vector<float>* points : {&x_, &y_, &center_x_, &center_y_}) {
    if (points->size() < count + kVector) points->resize(count + kVector);
  }
}

void TileCaster::reserve_samples(std::size_t count) {
  for (auto& plane : sampled_) plane.resize(std::max(plane.size(), count + kVector));
  ignored_.resize(std::max(ignored_.size(), count + kVector));
}

Shades TileCaster::samples() { return {{sampled_[0].data(), sampled_[1].data(), sampled_[2].data()}, ignored_.data()}; }

void TileCaster::place_row(const TilePart& part, int y) {
  for (std::size_t x = 0; x < kTile; ++x) {
    x_[x] = static_cast<float>(part.left) + static_cast<float>(x) + 0.5f;
    y_[x] = static_cast<float>(part.top + y) + 0.5f;
  }
}

// Includes adjacent pixels outside the image, so that edges at its outermost pixels are smooth, too.
void TileCaster::place_border(const TilePart& part) {
  for (std::size_t i = 0; i < kBorder; ++i) {
    const Place place = border_place(part, static_cast<int>(i));
    x_[i] = static_cast<float>(part.left + place.x) + 0.5f;
    y_[i] = static_cast<float>(part.top + place.y) + 0.5f;
  }
}

void TileCaster::place_samples(const TilePart& part, const std::vector<std::uint32_t>& pixels) {
  reserve_points(kSamples * pixels.size());
  std::size_t i = 0;
  for (const std::uint32_t pixel : pixels) {
    const float x = static_cast<float>(part.left + static_cast<int>(pixel % kTile));
    const float y = static_cast<float>(part.top + static_cast<int>(pixel / kTile));
    for (std::size_t sample = 0; sample < kSamples; ++sample, ++i) {
      x_[i] = x + kSampleX[sample];
      y_[i] = y + kSampleY[sample];
      center_x_[i] = x + 0.5f;
      center_y_[i] = y + 0.5f;
    }
  }
}

void TileCaster::put_in_blocks(std::vector<std::uint32_t>& pixels) {
  on_edge_.assign(kPixels, 0);
  for (const std::uint32_t pixel : pixels) on_edge_[pixel] = 1;
  pixels.clear();
  for (const std::uint32_t pixel : blocks()) {
    if (on_edge_[pixel] != 0) pixels.push_back(pixel);
  }
}

bool TileCaster::trace(CastScene& scene, const TilePart& part, bool smooth, TileSurfaces& to, std::uint32_t* depth) {
  const CastView& view = scene.aim(part.left - 1, part.top - 1, part.left + part.width + 1, part.top + part.height + 1);
  if (view.count == 0 && !scene.has_sky() && !view.glass) return false;
  constexpr float kMost = std::numeric_limits<float>::max();
  to.reach = {{kMost, kMost, kMost}, {-kMost, -kMost, -kMost}};
  to.edge_pixels.clear();
  to.centers.resize(kCenters, view.colored);
  reserve_points(kBorder);
  const bool meshes = any_mesh(view.solids, view.count);
  if (meshes) trace_blocks(view, part, to);
  for (int y = 0; y < part.height; ++y) {
    const Surfaces row = to.centers.from(bordered(0, y));
    place_row(part, y);
    const auto count = static_cast<std::size_t>(part.width);
    if (!meshes) lanes_->cast(view, x_.data(), y_.data(), count, row);
    lanes_->measure(view, x_.data(), y_.data(), count, row, to.reach, depth + y * kTile);
  }
  if (smooth) trace_edges(view, part, meshes, to);
  return to.reach.low[0] <= to.reach.high[0] || scene.has_sky() || view.glass;
}

void TileCaster::place_blocks(const TilePart& part) {
  blocks_.clear();
  for (const std::uint32_t pixel : blocks()) {
    const bool inside = static_cast<int>(pixel % kTile) < part.width && static_cast<int>(pixel / kTile) < part.height;
    if (inside) blocks_.push_back(pixel);
  }
  reserve_points(kPixels);
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    x_[i] = static_cast<float>(part.left + static_cast<int>(blocks_[i] % kTile)) + 0.5f;
    y_[i] = static_cast<float>(part.top + static_cast<int>(blocks_[i] / kTile)) + 0.5f;
  }
}

void TileCaster::trace_blocks(const CastView& view, const TilePart& part, TileSurfaces& to) {
  place_blocks(part);
  in_blocks_.resize(kPixels, view.colored);
  const Surfaces centers = to.centers.from(0), met = in_blocks_.from(0);
  lanes_->cast(view, x_.data(), y_.data(), blocks_.size(), met);
  for (std::size_t i = 0; i < blocks_.size(); ++i) copy(met, i, centers, bordered(blocks_[i]));
}

void TileCaster::shade_blocks(const ShadeView& view, const TilePart& part, TileSurfaces& from) {
  place_blocks(part);
  in_blocks_.resize(kPixels, view.cast.colored);
  const Surfaces centers = from.centers.from(0), met = in_blocks_.from(0);
  for (std::size_t i = 0; i < blocks_.size(); ++i) copy(centers, bordered(blocks_[i]), met, i);
  reserve_samples(blocks_.size());
  lanes_->shade(view, x_.data(), y_.data(), blocks_.size(), met, samples());
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    for (std::size_t c = 0; c < 3; ++c) light_[c][blocks_[i]] = sampled_[c][i];
    shadows_[bordered(blocks_[i])] = ignored_[i];
  }
}

void TileCaster::trace_edges(const CastView& view, const TilePart& part, bool meshes, TileSurfaces& to) {
  to.border.resize(kBorder, view.colored);
  const Surfaces border = to.border.from(0), centers = to.centers.from(0);
  place_border(part);
  lanes_->cast(view, x_.data(), y_.data(), kBorder, border);
  lanes_->measure(view, x_.data(), y_.data(), kBorder, border, to.reach, nullptr);
  for (std::size_t i = 0; i < kBorder; ++i) {
    const Place place = border_place(part, static_cast<int>(i));
    copy(border, i, centers, bordered(place.x, place.y));
  }
  const Surfaces first = to.centers.from(bordered(0, 0));
  to.edge_pixels.resize(kPixels + kVector);
  to.edge_pixels.resize(lanes_->edges(first.surface, meshes ? first.normal : nullptr, kBordered, part.width,
                                      part.height, to.edge_pixels.data()));
  if (meshes) put_in_blocks(to.edge_pixels);
  const std::size_t samples = kSamples * to.edge_pixels.size();
  to.edges.resize(samples, view.colored);
  place_samples(part, to.edge_pixels);
  const Surfaces edges = to.edges.from(0);
  lanes_->cast(view, x_.data(), y_.data(), samples, edges);
  lanes_->measure(view, x_.data(), y_.data(), samples, edges, to.reach, nullptr);
}

void TileCaster::shade(CastScene& scene, const TilePart& part, bool smooth, TileSurfaces& from, std::uint32_t* light) {
  const ShadeView& view = scene.light(from.reach);
  for (auto& plane : light_) plane.resize(kPixels + kVector);
  shadows_.resize(kCenters + kVector);
  reserve_points(kBorder);
  const bool meshes = any_shadow_of_a_mesh(view);
  if (meshes) shade_blocks(view, part, from);
  for (int y = 0; y < part.height && !meshes; ++y) {
    place_row(part, y);
    const std::size_t at = static_cast<std::size_t>(y) * kTile;
    lanes_->shade(
        view, x_.data(), y_.data(), static_cast<std::size_t>(part.width), from.centers.from(bordered(0, y)),
        {{light_[0].data() + at, light_[1].data() + at, light_[2].data() + at}, shadows_.data() + bordered(0, y)});
  }
  if (smooth) {
    find_shadow_edges(view, part, meshes, from);
    place_samples(part, shadow_pixels_);
    lanes_->slide(view.cast, center_x_.data(), center_y_.data(), x_.data(), y_.data(), shadow_edges_.size(),
                  shadow_edges_.from(0));
    shade_samples(view, shadow_pixels_, shadow_edges_);
    place_samples(part, from.edge_pixels);
    shade_samples(view, from.edge_pixels, from.edges);
  }
  for (int y = 0; y < part.height; ++y) {
    const std::size_t at = static_cast<std::size_t>(y) * kTile;
    const float* row[3] = {light_[0].data() + at, light_[1].data() + at, light_[2].data() + at};
    lanes_->store(row, static_cast<std::size_t>(part.width), light + 3 * at);
  }
}

// Finds the pixels with a neighbour that has other shadows, except those on an edge of an object.
void TileCaster::find_shadow_edges(const ShadeView& view, const TilePart& part, bool meshes, TileSurfaces& from) {
  reserve_samples(kBorder);
  place_border(part);
  lanes_->shade(view, x_.data(), y_.data(), kBorder, from.border.from(0), samples());
  for (std::size_t i = 0; i < kBorder; ++i) {
    const Place place = border_place(part, static_cast<int>(i));
    shadows_[bordered(place.x, place.y)] = ignored_[i];
  }
  shadow_pixels_.resize(kPixels + kVector);
  shadow_pixels_.resize(lanes_->edges(shadows_.data() + bordered(0, 0), nullptr, kBordered, part.width, part.height,
                                      shadow_pixels_.data()));
  on_edge_.assign(kPixels, 0);
  for (const std::uint32_t pixel : from.edge_pixels) on_edge_[pixel] = 1;
  std::erase_if(shadow_pixels_, [&](std::uint32_t pixel) { return on_edge_[pixel] != 0; });

  if (meshes) put_in_blocks(shadow_pixels_);
  shadow_edges_.resize(kSamples * shadow_pixels_.size(), view.cast.colored);
  const Surfaces centers = from.centers.from(0), edges = shadow_edges_.from(0);
  for (std::size_t i = 0; i < shadow_edges_.size(); ++i) {
    copy(centers, bordered(shadow_pixels_[i / kSamples]), edges, i);
  }
}

// Sets pixels to the mean of their samples.
void TileCaster::shade_samples(const ShadeView& view, const std::vector<std::uint32_t>& pixels, SurfaceList& surfaces) {
  reserve_samples(surfaces.size());
  lanes_->shade(view, x_.data(), y_.data(), surfaces.size(), surfaces.from(0), samples());
  for (std::size_t c = 0; c < 3; ++c) {
    const float* from = sampled_[c].data();
    for (const std::uint32_t pixel : pixels) {
      light_[c][pixel] = ((from[0] + from[1]) + (from[2] + from[3])) * 0.25f;
      from += kSamples;
    }
  }
}

}  // namespace motes::image
