#include "bindings/bindings.h"
#include "image/camera.h"
#include "image/footprint.h"
#include "image/scene.h"
#include "image/scenery.h"
#include "image/tone.h"

namespace motes::bindings {
namespace {

image::Sprite make_sprite(const std::string& kind, int pixels) {
  image::Sprite sprite;
  if (kind != "point" && kind != "disc") throw std::invalid_argument("kind must be point or disc, got '" + kind + "'");
  sprite.kind = kind == "point" ? image::Sprite::Kind::point : image::Sprite::Kind::disc;
  sprite.pixels = pixels;
  image::check(sprite);
  return sprite;
}

image::View::Path path_of(const std::string& name) {
  if (name == "auto") return image::View::Path::automatic;
  if (name == "gather") return image::View::Path::gather;
  if (name == "tiles") return image::View::Path::tiles;
  if (name == "composite") return image::View::Path::composite;
  throw std::invalid_argument("path must be auto, gather, tiles or composite, got '" + name + "'");
}

// A view is made step by step: what is not set keeps its default.
void bind_view(py::module_& m) {
  using image::View;
  py::class_<View> view(m, "View");
  view.def(py::init([](int width, int height) {
             View made;
             made.width = width;
             made.height = height;
             return made;
           }),
           py::arg("width"), py::arg("height"));
  view.def(
      "set_camera",
      [](View& v, image::Vector position, image::Vector look_at, image::Vector up, double fov_deg, double near) {
        v.camera = {position, look_at, up, fov_deg, near};
      },
      py::arg("position"), py::arg("look_at"), py::arg("up"), py::arg("fov_deg"), py::arg("near"));
  view.def(
      "add_object",
      [](View& v, const shapes::Shape& shape, image::Color color) { v.objects.push_back({shape, color}); },
      py::arg("shape"), py::arg("color"));
  view.def("set_background", [](View& v, image::Color color) { v.background = color; }, py::arg("color"));
  view.def("set_exposure", [](View& v, float exposure) { v.exposure = exposure; }, py::arg("exposure"));
  view.def("set_path", [](View& v, const std::string& name) { v.path = path_of(name); }, py::arg("name"));
  view.def("set_bloom", [](View& v, float part) { v.bloom = part; }, py::arg("part"));
  view.def("set_linear", [](View& v, bool keep) { v.linear = keep; }, py::arg("keep"));
  view.def("check", [](const View& v) { image::check(v); });
}

}  // namespace

void bind_image(py::module_& m) {
  py::class_<image::Sprite>(m, "Sprite").def(py::init(&make_sprite), py::arg("kind"), py::arg("pixels"));
  bind_view(m);
  m.def(
      "tone_16_bits",
      [](const FloatArray& light, double exposure) {
        const std::span<const float> values(light.data(), static_cast<std::size_t>(light.size()));
        return owned_array(image::tone_16_bits(values, exposure), {light.shape(), light.shape() + light.ndim()});
      },
      py::arg("light"), py::arg("exposure"));
}

}  // namespace motes::bindings
