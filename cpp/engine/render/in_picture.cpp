#include "engine/render/in_picture.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "engine/render/drawn.h"
#include "image/camera.h"

namespace motes::engine {
namespace {

// Returns where the particles are relative to the picture. Particles in view without a record are too dark or too
// small, which is no reason for a warning.
Sighted look(const image::View& view, const image::Drawn& particles) {
  const image::Lens lens = image::lens(view);
  Sighted found = Sighted::unknown;
  for (std::size_t i = 0; i < particles.count; ++i) {
    double ahead = 0, across = 0, upward = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double way = static_cast<double>(particles.position[axis][i]) - lens.eye[axis];
      ahead += way * lens.forward[axis];
      across += way * lens.right[axis];
      upward += way * lens.up[axis];
    }
    if (!(ahead >= view.camera.near)) {
      found = std::max(found, Sighted::behind);
    } else if (std::abs(across) * lens.focal_px <= 0.5 * view.width * ahead &&
               std::abs(upward) * lens.focal_px <= 0.5 * view.height * ahead) {
      return Sighted::inside;
    } else {
      found = Sighted::beside;
    }
  }
  return found;
}

}  // namespace

std::vector<Sighted> sighted(const Script& script, const Calculator& calculator,
                             const std::vector<std::uint64_t>& records, std::vector<std::uint64_t>& pictures) {
  const std::optional<image::View>& view = script.record.view;
  pictures.resize(records.size());
  std::vector<Sighted> found(records.size(), Sighted::unknown);
  for (std::size_t i = 0; i < records.size(); ++i) {
    if (script.systems[i]->counts.alive == 0) continue;
    const std::uint64_t picture = ++pictures[i];
    if (records[i] != 0) {
      found[i] = Sighted::inside;
    } else if (view && (picture == 1 || picture % kLaterPictures == 0)) {
      found[i] = look(*view, drawn(calculator.populations[i]->store));
    }
  }
  return found;
}

}  // namespace motes::engine
