#include "image/camera.h"

#include <algorithm>
#include <numbers>
#include <string>

#include "base/enumerators.h"
#include "base/vectors.h"
#include "image/curves.h"

namespace motes::image {
namespace {

Lens lens_of(const Camera& camera, int height) {
  Lens lens;
  lens.eye = camera.position;
  lens.forward = unit(camera.look_at - camera.position);
  lens.right = unit(cross(lens.forward, camera.up));
  lens.up = cross(lens.right, lens.forward);
  lens.focal_px = 0.5 * height / tangent(camera.fov_deg * (std::numbers::pi / 360));
  return lens;
}

}  // namespace

std::optional<CameraFault> no_direction(const Camera& camera) {
  const Vector toward = camera.look_at - camera.position;
  if (!(length(toward) > 1e-9)) return CameraFault{"camera.look_at", "different from camera.position", camera.look_at};
  if (!(length(camera.up) > 1e-9)) return CameraFault{"camera.up", "longer than 0", camera.up};
  if (length(cross(unit(toward), unit(camera.up))) > 1e-6) return std::nullopt;
  return CameraFault{"camera.up", "not parallel to the direction of view", camera.up};
}

View::Path path_named(const std::string& name) {
  return name == "auto" ? View::Path::automatic : base::enumerator<View::Path>("path", name);
}

Lens lens(const View& view) { return lens_of(view.camera, view.height); }

double blur_of(const View& view) {
  return view.camera.aperture > 0 ? view.camera.aperture * lens(view).focal_px / view.camera.focus : 0;
}

Camera camera_at(const View& view, double back) {
  if (!view.before) return view.camera;
  const auto between = [&](const auto& now, const auto& before) { return now * (1 - back) + before * back; };
  const Camera &now = view.camera, &before = *view.before;
  Camera camera = now;
  camera.position = between(now.position, before.position);
  camera.look_at = between(now.look_at, before.look_at);
  camera.up = between(unit(now.up), unit(before.up));
  camera.fov_deg =
      now.fov_deg + (before.fov_deg - now.fov_deg) * std::min(back, 1.0);  // beyond 1 it may leave its range
  return no_direction(camera) ? now : camera;
}

Lens lens_at_opening(const View& view) { return lens_of(camera_at(view, view.shutter), view.height); }

}  // namespace motes::image
