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

image::View make_view(int width, int height, const std::vector<image::Vector>& camera, double fov_deg, double near,
                      image::Color background, float exposure,
                      const std::vector<std::pair<shapes::Shape, image::Color>>& objects, const std::string& path,
                      bool linear) {
  image::View view;
  view.width = width;
  view.height = height;
  view.camera = {camera.at(0), camera.at(1), camera.at(2), fov_deg, near};
  view.background = background;
  view.exposure = exposure;
  for (const auto& [shape, color] : objects) view.objects.push_back({shape, color});
  view.path = path_of(path);
  view.linear = linear;
  image::check(view);
  return view;
}

}  // namespace

void bind_image(py::module_& m) {
  py::class_<image::Sprite>(m, "Sprite").def(py::init(&make_sprite), py::arg("kind"), py::arg("pixels"));
  py::class_<image::View>(m, "View").def(py::init(&make_view), py::arg("width"), py::arg("height"), py::arg("camera"),
                                         py::arg("fov_deg"), py::arg("near"), py::arg("background"),
                                         py::arg("exposure"), py::arg("objects"), py::arg("path") = "auto",
                                         py::arg("linear") = false);
  m.def(
      "tone_16_bits",
      [](const FloatArray& light, double exposure) {
        const std::span<const float> values(light.data(), static_cast<std::size_t>(light.size()));
        return owned_array(image::tone_16_bits(values, exposure), {light.shape(), light.shape() + light.ndim()});
      },
      py::arg("light"), py::arg("exposure"));
}

}  // namespace motes::bindings
