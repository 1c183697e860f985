// The picture that a sprite shows, or several of which each particle shows one.
#pragma once

#include <cstdint>
#include <string>
#include <tuple>
#include <vector>

#include "base/checks.h"
#include "base/members.h"
#include "expressions/expression.h"
#include "meshes/assets.h"
#include "shapes/shape.h"

namespace motes::image {

/// How a picture is divided into tiles of equal size, numbered row by row from the top; only the first `count` are
/// used.
struct Tiles {
  std::uint16_t columns = 1, rows = 1;
  std::uint32_t count = 1;

  bool cut() const { return count > 1; }
  auto operator<=>(const Tiles&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Tiles& tiles) {
  visit(tiles.columns, tiles.rows, tiles.count);
}

/// Greatest Tiles::columns and Tiles::rows.
inline constexpr int kMostTiles = 256;

/// Returns whether columns and rows are within their limits and hold `count` tiles. A picture that is not divided must
/// have one column and one row.
inline bool valid(const Tiles& tiles) {
  if (!tiles.cut()) return tiles == Tiles{};
  const bool within = tiles.columns >= 1 && tiles.columns <= kMostTiles && tiles.rows >= 1 && tiles.rows <= kMostTiles;
  return within && tiles.count <= std::uint32_t{tiles.columns} * tiles.rows;
}

/// Which tile each particle shows: a number from 0 on, which wraps around after the last tile. A fraction blends a tile
/// with the next one.
struct Pick {
  expressions::Expression number;  // empty: a random whole number
  std::vector<shapes::Shape> shapes;  // shapes that `number` tests

  bool operator==(const Pick&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Pick& pick) {
  visit(pick.number, pick.shapes);
}

/// A picture, its tiles, and how a particle picks one.
struct Sheet {
  meshes::AssetKey picture = 0;
  Tiles tiles{};
  Pick pick{};

  static constexpr std::tuple kMembers{base::Member{"picture", &Sheet::picture}, base::Member{"tiles", &Sheet::tiles},
                                       base::Member{"", &Sheet::pick}};
  bool operator==(const Sheet&) const = default;

  /// Returns the part that painters need: records carry the numbers of picked tiles.
  Sheet painted() const { return {picture, tiles}; }
};

inline void check(const Sheet& sheet) {
  if (sheet.picture == 0) base::refuse("sprite.picture", "the key of a picture", "0");
  if (!valid(sheet.tiles)) {
    base::refuse("sprite.tiles", "1..256 columns and rows of a picture",
                 std::to_string(sheet.tiles.columns) + " x " + std::to_string(sheet.tiles.rows));
  }
  for (const shapes::Shape& shape : sheet.pick.shapes) shapes::check_region(shape);
}

}  // namespace motes::image
