#include "lab/bench/bench_scenery.h"

#include <algorithm>
#include <functional>
#include <stdexcept>
#include <vector>

#include "image/raycast/scenery.h"
#include "lab/bench/bench_scene.h"
#include "meshes/assets.h"
#include "meshes/bvh.h"
#include "simd/isa.h"

namespace motes::bench {
namespace {

using namespace image;

Solid solid(shapes::Kind kind, std::initializer_list<float> numbers, Color color) {
  Solid made;
  made.shape.kind = kind;
  std::copy(numbers.begin(), numbers.end(), made.shape.number);
  made.color = color;
  return made;
}

Solid ground() { return solid(shapes::Kind::plane, {0, 0, 0, 0, 1, 0}, {0.6f, 0.6f, 0.6f}); }

std::vector<Solid> shapes_on_a_plane() {
  return {ground(),
          solid(shapes::Kind::sphere, {0, 1, 0, 1, 0}, {1, 0.3f, 0.2f}),
          solid(shapes::Kind::box, {1.5f, 0, -1, 2.5f, 1.5f, 0}, {0.2f, 0.5f, 1}),
          solid(shapes::Kind::cylinder, {-2, 0, 0, -2, 1.4f, 0.3f, 0.5f, 0.3f}, {0.3f, 0.9f, 0.3f}),
          solid(shapes::Kind::cone, {-1, 2, -2, -1, 0, -2, 0.8f, 0}, {0.9f, 0.9f, 0.2f}),
          solid(shapes::Kind::disc, {3.2f, 1, -2, 1, 0.2f, 1, 1, 0.4f}, {1, 0.5f, 1}),
          solid(shapes::Kind::rectangle, {-4, 0, -3, 1.5f, 0, 0.5f, 0, 1.6f, 0}, {0.4f, 0.4f, 0.4f}),
          solid(shapes::Kind::triangle, {0.5f, 0, 2, 1.5f, 0, 2.4f, 1, 0.9f, 2}, {0.1f, 0.8f, 0.8f})};
}

// A ball with dents, two metres wide.
meshes::Mesh dented_ball(std::uint32_t around, std::uint32_t rings) {
  meshes::Mesh mesh;
  const auto part = [](std::uint32_t i, std::uint32_t n) { return static_cast<float>(i) / static_cast<float>(n); };
  for (std::uint32_t ring = 0; ring <= rings; ++ring) {
    for (std::uint32_t i = 0; i < around; ++i) {
      // A square bent into a circle, which needs no sine.
      const float turn = 4 * part(i, around), height = 2 * part(ring, rings) - 1;
      const auto side = static_cast<int>(turn);
      const float along = 2 * (turn - static_cast<float>(side)) - 1;
      const float corner[4][2] = {{along, -1}, {1, along}, {-along, 1}, {-1, -along}};
      const float x = corner[side][0] * (1 - height * height), z = corner[side][1] * (1 - height * height);
      const float dent = 0.9f + 0.1f * static_cast<float>((i / 4 + ring / 4) % 2);
      const float scale = dent / __builtin_sqrtf(x * x + z * z + height * height);
      mesh.vertices.insert(mesh.vertices.end(), {x * scale, 1 + height * scale, z * scale});
    }
  }
  for (std::uint32_t ring = 0; ring < rings; ++ring) {
    for (std::uint32_t i = 0; i < around; ++i) {
      const std::uint32_t a = ring * around + i, b = ring * around + (i + 1) % around;
      mesh.triangles.insert(mesh.triangles.end(), {a, b, a + around, b, b + around, a + around});
    }
  }
  return mesh;
}

View view_of(int width, int height, std::vector<Solid> objects) {
  View view;
  view.width = width;
  view.height = height;
  view.camera.position = {3, 4, 9};
  view.camera.look_at = {0, 0.5, 0};
  view.background = {0.05f, 0.06f, 0.09f};
  view.objects = std::move(objects);
  return view;
}

double median_ms(View view, int frames, const std::function<void(View&, int)>& change) {
  Scenery scenery;
  std::vector<double> ms;
  for (int frame = 0; frame <= frames; ++frame) {  // the first one allocates memory
    change(view, frame);
    const double start = cpu_now_ms();
    scenery.prepare(view);
    scenery.render_all();
    if (frame > 0) ms.push_back(cpu_now_ms() - start);
  }
  return median(ms);
}

}  // namespace

SceneryBench scenery_bench(int width, int height, int frames) {
  if (frames < 1) throw std::invalid_argument("frames must be at least 1");
  SceneryBench result;
  result.width = width;
  result.height = height;
  result.frames = frames;
  result.isa = simd::name(simd::isa());
  const auto camera_moves = [](View& view, int frame) { view.camera.position[0] = 3 + 0.1 * frame; };
  const auto light_moves = [](View& view, int frame) { view.lights[0].position[0] = 0.1 * frame; };

  View shapes = view_of(width, height, shapes_on_a_plane());
  result.ms_shapes = median_ms(shapes, frames, camera_moves);
  shapes.lights = {{{0, 3, 2}, {1, 0.6f, 0.3f}, 4}, {{-3, 2, 2}, {0.3f, 0.6f, 1}, 3}, {{3, 1, 2}, {1, 1, 1}, 1}};
  result.ms_shapes_lights = median_ms(shapes, frames, camera_moves);
  result.ms_light_moves = median_ms(shapes, frames, light_moves);

  const meshes::Mesh ball = dented_ball(400, 125);
  result.triangles = ball.triangles.size() / 3;
  const double start = cpu_now_ms();
  meshes::build_bvh(ball);
  result.ms_build_mesh = cpu_now_ms() - start;
  Solid stone;
  stone.mesh = keep(ball);
  stone.color = {0.8f, 0.7f, 0.6f};
  result.ms_mesh = median_ms(view_of(width, height, {ground(), stone}), frames, camera_moves);
  return result;
}

}  // namespace motes::bench
