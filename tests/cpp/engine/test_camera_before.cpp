// The previous frame's camera in the record of a frame.
#include "engine/state/script.h"
#include "image/camera.h"
#include "support/check.h"

namespace motes::test_camera_before {
namespace {

image::View view_from(double x, float shutter) {
  image::View view;
  view.width = view.height = 8;
  view.camera.position = {x, 0, 5};
  view.shutter = shutter;
  return view;
}

}  // namespace

TEST(an_open_shutter_knows_the_camera_of_the_frame_before) {
  engine::Script script;
  const engine::Settings settings;
  const auto before = [&](std::uint64_t frame, const std::optional<image::View>& view) {
    const auto verb = view ? recording::Verb::render : recording::Verb::step;
    engine::write_record(script, settings, frame, verb, view, "");
    return script.record.view ? script.record.view->before : std::nullopt;
  };
  CHECK(!before(0, view_from(0, 0.5f)));  // the first frame
  CHECK(before(1, view_from(1, 0.5f)) == view_from(0, 0).camera);
  CHECK(!before(2, view_from(2, 0)));  // needs no camera: records stay as they are
  CHECK(before(3, view_from(3, 1)) == view_from(2, 0).camera);
  CHECK(!before(4, std::nullopt));
  CHECK(!before(5, view_from(5, 1)));  // the frame before was not drawn
  image::View replayed = view_from(6, 1);
  replayed.before = view_from(-6, 1).camera;
  CHECK(before(6, replayed) == view_from(-6, 1).camera);  // a recorded scene contains it
}

TEST(a_shutter_opens_that_part_of_a_frame_ago) {
  image::View view = view_from(4, 0.25f);
  CHECK(image::lens_at_opening(view).eye[0] == 4);  // there was no frame before
  view.before = view_from(0, 0).camera;
  view.before->fov_deg = 0.5 * view.camera.fov_deg;
  const image::Lens opening = image::lens_at_opening(view);
  CHECK_NEAR(opening.eye[0], 3, 1e-12);
  view.camera.fov_deg *= 0.875;
  CHECK_NEAR(opening.focal_px, image::lens(view).focal_px, 1e-9);
}

}  // namespace motes::test_camera_before
