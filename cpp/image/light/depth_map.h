// Depth maps of lights: how far each ray gets before it meets an opaque particle, for shadows with edges.
//
// A map consists of planes of kDepthSide^2 texels in pages of kDepthPage^2, of which only those that something covers
// are kept. A lamp has a plane per face of a cube, along the world's axes; the sun has planes around the camera's
// target, each with texels twice as wide as those of the plane before. Texels belong to a lattice that is fixed in the
// world: it depends on the camera and the light, never on particles. They hold minus the depth of what is nearest to
// the light, so that maps of several ranks are merged by their maxima.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace motes::image {

inline constexpr int kDepthSide = 2048, kDepthPage = 64, kDepthPages = kDepthSide / kDepthPage;
inline constexpr int kFaces = 6, kSunPlanes = 5;
inline constexpr int kDepthMargin = 64;  // greatest radius of a filter, texels
/// Texels of a face per tangent of 45 degrees; faces reach farther, so that no filter crosses an edge of the cube.
inline constexpr float kFaceTexels = kDepthSide / 2 - kDepthMargin;
inline constexpr float kNoDepth = -std::numeric_limits<float>::max();

/// The space of a map. That of the sun has coordinates along three unit vectors, from `origin` on.
struct DepthSpace {
  bool point = false;
  float origin[3]{}, right[3]{}, up[3]{}, ahead[3]{};
  float texels = 0;  // of the sun's first plane, per m
  float first[kSunPlanes][2]{};  // first column and row of the sun's planes, in their own texels
  float size = 0;  // tangent of half the sun's size; radius of a lamp, m

  int planes() const { return point ? kFaces : kSunPlanes; }
};

/// A map as kernels read it; without texels it is empty.
struct DepthView {
  DepthSpace space;
  const float* pages = nullptr;  // which page of `texels` each page of each plane is, row by row; 0: nothing is there
  const float* texels = nullptr;
  const struct DepthTaps* taps = nullptr;
};

/// Places at which a filter tests a map, on a disc of radius 1. Those at its rim are among the first kFirst.
struct DepthTaps {
  static constexpr int kAll = 32, kFirst = 12;
  float x[kAll], y[kAll];
};

/// The sky's light, as that of suns in several directions, and the depth maps of these.
struct SkyDepths {
  static constexpr int kMaps = 8;
  DepthView map[kMaps];
  float toward[kMaps][3]{};
  float part = 0;  // of the sky's light that is lost where it is blocked from all sides: see View::occlusion
  float reach = 0;  // distance up to which something blocks it, less the farther away it is, m
};

class DepthMap {
 public:
  static constexpr std::size_t kTexels = std::size_t{kDepthPage} * kDepthPage;  // of a page

  void begin(const DepthSpace& space);
  const DepthSpace& space() const { return space_; }
  std::size_t pages() const { return pages_.size(); }

  /// Returns the texels of a page, row by row, which it creates if there are none; valid until the next call.
  float* page(std::size_t number);
  float* page(int plane, int column, int row) {
    return page(static_cast<std::size_t>((plane * kDepthPages + row) * kDepthPages + column));
  }
  bool has(std::size_t page) const { return pages_[page] != 0; }

  /// Keeps the nearest of both maps.
  void merge(const DepthMap& other);

  DepthView view() const;

 private:
  DepthSpace space_;
  std::vector<float> pages_;  // as DepthView::pages
  std::vector<float> texels_;  // those of no page are the first ones
};

/// Replaces texels by others where these are nearer.
void keep_nearest_texels(const float* from, float* to);

}  // namespace motes::image
