#include "base/enumerators.h"
#include "bindings/bindings.h"
#include "image/camera.h"
#include "image/checks.h"
#include "image/footprint.h"
#include "image/raycast/scenery.h"
#include "image/scene.h"
#include "image/tone.h"
#include "meshes/assets.h"

namespace motes::bindings {
namespace {

// Fills members that are described (base/members.h) from the arguments of the same names, and counts those that it
// used.
class Arguments {
 public:
  explicit Arguments(const py::kwargs& given) : given_(given) {}

  template <class T>
  void operator()(const char* name, T& member) const {
    if constexpr (base::Described<T>) {
      base::for_each_member(member, *this);
    } else if (*name != 0) {
      if (!given_.contains(name)) throw base::InvalidArgument(name, "be given");
      set(name, given_[name], member);
      ++used_;
    }
  }
  std::size_t used() const { return used_; }

 private:
  template <class T>
  static void set(const char* name, const py::handle& value, T& member) {
    if constexpr (std::is_enum_v<T>) {
      member = base::enumerator<T>(name, value.cast<std::string>());
    } else {
      member = value.cast<T>();
    }
  }
  static void set(const char*, const py::handle& value, image::Tiles& tiles) {
    const auto [columns, rows, count] = value.cast<std::tuple<std::uint16_t, std::uint16_t, std::uint32_t>>();
    tiles = {columns, rows, count};
  }

  const py::kwargs& given_;
  mutable std::size_t used_ = 0;
};

// Makes a sprite from the members that all kinds have, and those of its own.
image::Sprite make_sprite(const std::string& kind, const py::kwargs& members) {
  image::Sprite sprite{base::enumerator<image::Sprite::Kind>("kind", kind)};
  const Arguments arguments(members);
  arguments("", sprite);
  std::visit([&](auto& own) { arguments("", own); }, sprite.look);
  if (arguments.used() != members.size()) throw base::InvalidArgument("kind", "have all members given", kind);
  image::check(sprite);
  return sprite;
}

// Binds View, which is built step by step: values that are not set keep their defaults.
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
  // The size and the content of the picture.
  view.def_readonly("width", &View::width)
      .def_readonly("height", &View::height)
      .def_readonly("exposure", &View::exposure)
      .def_readonly("linear", &View::linear)
      .def_readonly("layers", &View::layers);
  view.def(
      "set_camera",
      [](View& v, Vector position, Vector look_at, Vector up, double fov_deg, double near, double focus,
         double aperture) { v.camera = {position, look_at, up, fov_deg, near, focus, aperture}; },
      py::arg("position"), py::arg("look_at"), py::arg("up"), py::arg("fov_deg"), py::arg("near"), py::arg("focus"),
      py::arg("aperture"));
  const auto def_solid = [&](const char* name, auto mesh_of) {
    view.def(
        name,
        [mesh_of](View& v, const shapes::Shape& shape, image::Color color, float light, meshes::AssetKey image,
                  float scale, float roughness, float metal, meshes::AssetKey finish_image, float glass) {
          v.objects.push_back(
              {shape, color, mesh_of(shape), light, image, scale, {roughness, metal}, finish_image, glass});
        },
        py::arg("shape"), py::arg("color"), py::arg("light"), py::arg("image"), py::arg("scale"), py::arg("roughness"),
        py::arg("metal"), py::arg("finish_image"), py::arg("glass"));
  };
  def_solid("add_object", [](const shapes::Shape&) { return meshes::AssetKey{0}; });
  def_solid("add_mesh", [](const shapes::Shape& mesh) { return mesh.mesh; });
  view.def(
      "set_sun",
      [](View& v, Vector direction, float size_deg, image::Color color, float power) {
        v.sun = direction;
        v.sun_size = size_deg;
        v.sun_color = color;
        v.sun_power = power;
      },
      py::arg("direction"), py::arg("size_deg"), py::arg("color"), py::arg("power"));
  view.def(
      "add_light",
      [](View& v, Vector position, image::Color color, float power, float radius, Vector spot, float spot_deg) {
        v.lights.push_back({position, color, power, radius, {spot, spot_deg}});
      },
      py::arg("position"), py::arg("color"), py::arg("power"), py::arg("radius"), py::arg("spot"), py::arg("spot_deg"));
  view.def("set_background", [](View& v, image::Color color) { v.background = color; }, py::arg("color"));
  view.def(
      "set_gradient",
      [](View& v, image::Color horizon, image::Color zenith, image::Color ground) {
        v.sky = {image::Sky::Kind::gradient, horizon, zenith, ground, 0};
      },
      py::arg("horizon"), py::arg("zenith"), py::arg("ground"));
  view.def(
      "set_sky", [](View& v, meshes::AssetKey picture) { v.sky = {image::Sky::Kind::picture, {}, {}, {}, picture}; },
      py::arg("picture"));
  view.def(
      "set_fog", [](View& v, image::Color color, float metres) { v.fog = {color, metres}; }, py::arg("color"),
      py::arg("metres"));
  view.def("set_exposure", [](View& v, float exposure) { v.exposure = exposure; }, py::arg("exposure"));
  view.def("set_path", [](View& v, const std::string& name) { v.path = image::path_named(name); }, py::arg("name"));
  view.def("set_shutter", [](View& v, float part) { v.shutter = part; }, py::arg("part"));
  view.def("set_bare", [](View& v, bool bare) { v.bare = bare; }, py::arg("bare"));
  view.def("set_full_height", [](View& v, int pixels) { v.full_height = pixels; }, py::arg("pixels"));
  view.def("set_bloom", [](View& v, float part) { v.bloom = part; }, py::arg("part"));
  view.def("set_occlusion", [](View& v, float part) { v.occlusion = part; }, py::arg("part"));
  view.def("set_smooth", [](View& v, bool smooth) { v.smooth = smooth; }, py::arg("smooth"));
  view.def("set_layers", [](View& v, std::uint8_t layers) { v.layers = layers; }, py::arg("layers"));
  view.def("set_linear", [](View& v, bool keep) { v.linear = keep; }, py::arg("keep"));
  view.def("check", [](const View& v) { image::check(v); });
}

// Binds pictures and meshes, which the process keeps by a key of their content.
void bind_assets(py::module_& m) {
  using Bytes = py::array_t<std::uint8_t, py::array::c_style | py::array::forcecast>;
  using Indices = py::array_t<std::uint32_t, py::array::c_style | py::array::forcecast>;
  m.def(
      "keep_picture",
      [](const Bytes& rgba) {
        meshes::Picture picture;
        picture.height = static_cast<std::int32_t>(rgba.shape(0));
        picture.width = static_cast<std::int32_t>(rgba.shape(1));
        picture.rgba.assign(rgba.data(), rgba.data() + rgba.size());
        return meshes::keep(std::move(picture));
      },
      py::arg("rgba"));
  m.def(
      "keep_light",
      [](const FloatArray& light) {
        meshes::Picture picture;
        picture.height = static_cast<std::int32_t>(light.shape(0));
        picture.width = static_cast<std::int32_t>(light.shape(1));
        picture.light.assign(light.data(), light.data() + light.size());
        return meshes::keep(std::move(picture));
      },
      py::arg("light"));
  m.def(
      "keep_mesh",
      [](const FloatArray& vertices, const Indices& triangles, const FloatArray& colors, const FloatArray& density,
         const FloatArray& uv, const FloatArray& normals) {
        meshes::Mesh mesh;
        mesh.vertices.assign(vertices.data(), vertices.data() + vertices.size());
        mesh.triangles.assign(triangles.data(), triangles.data() + triangles.size());
        mesh.colors.assign(colors.data(), colors.data() + colors.size());
        mesh.density.assign(density.data(), density.data() + density.size());
        mesh.uv.assign(uv.data(), uv.data() + uv.size());
        mesh.normals.assign(normals.data(), normals.data() + normals.size());
        return meshes::keep(std::move(mesh));
      },
      py::arg("vertices"), py::arg("triangles"), py::arg("colors"), py::arg("density"), py::arg("uv"),
      py::arg("normals"));
}

}  // namespace

void bind_image(py::module_& m) {
  py::class_<image::Sprite>(m, "Sprite")
      .def(py::init(&make_sprite), py::arg("kind"))
      .def(
          "picked",
          [](image::Sprite sprite, const Steps& number, const std::vector<shapes::Shape>& shapes) {
            if (image::Sheet* sheet = sprite.sheet()) sheet->pick = {expression(number), shapes};
            return sprite;
          },
          py::arg("number"), py::arg("shapes"));
  bind_assets(m);
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
