// point, disc, sphere: kinds of sprites without members of their own.
#pragma once

#include <tuple>

namespace motes::image {

/// No size: as small as a pixel.
struct PointSprite {
  static constexpr std::tuple<> kMembers{};
  bool operator==(const PointSprite&) const = default;
};

/// Flat in the middle, soft at the edge.
struct DiscSprite {
  static constexpr std::tuple<> kMembers{};
  bool operator==(const DiscSprite&) const = default;
};

/// Lit by the sun and the sky, round in depth.
struct SphereSprite {
  static constexpr std::tuple<> kMembers{};
  bool operator==(const SphereSprite&) const = default;
};

}  // namespace motes::image
