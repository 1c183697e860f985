#include "image/light/image_levels.h"

#include <algorithm>
#include <array>
#include <map>
#include <memory>
#include <mutex>
#include <utility>

#include "base/invalid_argument.h"

namespace motes::image {
namespace {

constexpr double kOne = 32767;  // fits products of signed 16-bit numbers

// Inverts sRGB's curve with + - * / only: ((x + 0.055) / 1.055)^2.4 by Newton's method on y^5 = v^12.
double linear_of(double encoded) {
  if (encoded <= 0.04045) return encoded / 12.92;
  const double v = (encoded + 0.055) / 1.055;
  const double v3 = v * v * v, v12 = v3 * v3 * v3 * v3;
  double y = 1;  // from above: the function is convex, so it converges
  for (int i = 0; i < 60; ++i) {
    const double y4 = y * y * y * y;
    y -= (y4 * y - v12) / (5 * y4);
  }
  return y;
}

std::array<double, 256> linear_table() {
  std::array<double, 256> table{};
  for (std::size_t i = 0; i < table.size(); ++i) table[i] = linear_of(static_cast<double>(i) / 255);
  return table;
}

std::size_t texel(int width, int x, int y) {
  return 4 * (static_cast<std::size_t>(y + 1) * static_cast<std::size_t>(width + 2) + static_cast<std::size_t>(x + 1));
}

std::vector<std::uint16_t> framed(int width, int height) {
  return std::vector<std::uint16_t>(4 * static_cast<std::size_t>(width + 2) * static_cast<std::size_t>(height + 2));
}

std::vector<std::uint16_t> first_level(const meshes::Picture& picture) {
  static const std::array<double, 256> linear = linear_table();
  std::vector<std::uint16_t> texels = framed(picture.width, picture.height);
  const std::uint8_t* from = picture.rgba.data();
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x, from += 4) {
      std::uint16_t* to = texels.data() + texel(picture.width, x, y);
      const double alpha = from[3] / 255.0;
      for (int c = 0; c < 3; ++c) to[c] = static_cast<std::uint16_t>(linear[from[c]] * alpha * kOne + 0.5);
      to[3] = static_cast<std::uint16_t>(alpha * kOne + 0.5);
    }
  }
  return texels;
}

// One side of a level.
struct Side {
  int pixels;
  double exact;  // pixels it would have by exact halving

  // Returns the side of the next smaller level. Between one and two pixels it keeps two: a single one would look
  // blurred.
  Side half() const {
    const double half = exact / 2;
    return {half >= 2 ? static_cast<int>(half + 0.5) : half > 1 ? 2 : 1, half};
  }
  float scale() const { return static_cast<float>(pixels / exact); }
};

// The pixels of a larger side that one pixel of a smaller side averages: first, first + 1, ..., with their weights.
struct Share {
  int first;
  std::vector<std::uint64_t> parts;  // they add up to the pixels of the larger side
};

std::vector<Share> shares_of(const Side& from, const Side& to) {
  const auto m = static_cast<std::uint64_t>(from.pixels), n = static_cast<std::uint64_t>(to.pixels);
  std::vector<Share> shares;
  for (std::uint64_t i = 0; i < n; ++i) {
    Share share{static_cast<int>(i * m / n), {}};
    for (std::uint64_t j = i * m / n; j * n < (i + 1) * m; ++j) {
      share.parts.push_back(std::min((j + 1) * n, (i + 1) * m) - std::max(j * n, i * m));
    }
    shares.push_back(std::move(share));
  }
  return shares;
}

std::uint16_t most_alpha(const std::vector<std::uint16_t>& texels) {
  std::uint16_t most = 1;
  for (std::size_t i = 3; i < texels.size(); i += 4) most = std::max(most, texels[i]);
  return most;
}

std::vector<std::uint16_t> smaller(const std::vector<std::uint16_t>& from, const Side (&from_sides)[2],
                                   const Side (&sides)[2]) {
  const std::vector<Share> columns = shares_of(from_sides[0], sides[0]), rows = shares_of(from_sides[1], sides[1]);
  const auto all = static_cast<std::uint64_t>(from_sides[0].pixels) * static_cast<std::uint64_t>(from_sides[1].pixels);
  std::vector<std::uint16_t> to = framed(sides[0].pixels, sides[1].pixels);
  for (std::size_t y = 0; y < rows.size(); ++y) {
    for (std::size_t x = 0; x < columns.size(); ++x) {
      std::array<std::uint64_t, 4> sum{};
      for (std::size_t r = 0; r < rows[y].parts.size(); ++r) {
        for (std::size_t k = 0; k < columns[x].parts.size(); ++k) {
          const std::size_t at =
              texel(from_sides[0].pixels, columns[x].first + static_cast<int>(k), rows[y].first + static_cast<int>(r));
          for (std::size_t c = 0; c < 4; ++c) sum[c] += rows[y].parts[r] * columns[x].parts[k] * from[at + c];
        }
      }
      const std::size_t at = texel(sides[0].pixels, static_cast<int>(x), static_cast<int>(y));
      for (std::size_t c = 0; c < 4; ++c) to[at + c] = static_cast<std::uint16_t>((sum[c] + all / 2) / all);
    }
  }
  return to;
}

// Copies one tile of a picture.
meshes::Picture tile_of(const meshes::Picture& picture, const Tiles& tiles, std::uint32_t number) {
  meshes::Picture tile{picture.width / tiles.columns, picture.height / tiles.rows, {}};
  const std::size_t row = 4 * static_cast<std::size_t>(tile.width), step = 4 * static_cast<std::size_t>(picture.width);
  const auto first_row = static_cast<std::size_t>(tile.height) * (number / tiles.columns);
  const std::uint8_t* from = picture.rgba.data() + first_row * step + row * (number % tiles.columns);
  for (int y = 0; y < tile.height; ++y, from += step) tile.rgba.insert(tile.rgba.end(), from, from + row);
  return tile;
}

}  // namespace

ImageLevels::ImageLevels(const meshes::Picture& picture, const Tiles& tiles) {
  if (picture.width % tiles.columns != 0 || picture.height % tiles.rows != 0) {
    throw base::InvalidArgument("sprite.tiles", "divide the picture's sides");
  }
  for (std::uint32_t number = 0; number < tiles.count; ++number) add(tile_of(picture, tiles, number));
}

void ImageLevels::add(const meshes::Picture& picture) {
  Side sides[] = {{picture.width, double(picture.width)}, {picture.height, double(picture.height)}};
  const auto add_level = [&](std::vector<std::uint16_t> texels) {
    texels_.push_back(std::move(texels));
    levels_.push_back({texels_.back().data(), sides[0].pixels, sides[1].pixels, sides[0].scale(), sides[1].scale(),
                       most_alpha(texels_.back())});
  };
  add_level(first_level(picture));
  std::uint64_t alpha = 0;
  for (std::size_t i = 3; i < picture.rgba.size(); i += 4) alpha += picture.rgba[i];
  const double longer = std::max(picture.width, picture.height);
  cover_.push_back(static_cast<float>(static_cast<double>(alpha) / (255 * longer * longer)));
  while (sides[0].pixels > 1 || sides[1].pixels > 1) {
    const Side halves[] = {sides[0].half(), sides[1].half()};
    std::vector<std::uint16_t> texels = smaller(texels_.back(), sides, halves);
    std::copy_n(halves, 2, sides);
    add_level(std::move(texels));
  }
}

const ImageLevels& image_levels(meshes::AssetKey key, const Tiles& tiles) {
  static std::mutex mutex;
  static std::map<std::pair<meshes::AssetKey, Tiles>, std::unique_ptr<const ImageLevels>> all;
  const std::scoped_lock lock(mutex);
  auto& levels = all[{key, tiles}];
  if (levels == nullptr) levels = std::make_unique<const ImageLevels>(*meshes::picture(key), tiles);
  return *levels;
}

}  // namespace motes::image
