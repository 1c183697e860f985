#include "image/test_image_scene.h"

#include "support/isas.h"

namespace motes::image_test {

Cloud random_cloud(std::size_t count, std::uint64_t seed, bool colored) {
  std::uint64_t state = seed * 0x9e3779b97f4a7c15u + 1;
  const auto draw = [&](float low, float high) {
    state = state * 6364136223846793005u + 1442695040888963407u;
    return low + (high - low) * (static_cast<float>(state >> 40) / 16777216.0f);
  };
  Cloud cloud(count, colored);
  for (std::size_t i = 0; i < count; ++i) {
    const float place[] = {draw(-6, 6), draw(-4, 4), draw(-5, 11)};  // in this order with every compiler
    cloud.place(i, place[0], place[1], place[2]);
    for (auto& c : cloud.color) c[i] = draw(-0.1f, 1.1f);
    cloud.alpha[i] = draw(0, 1);
  }
  return cloud;
}

Cloud every(const Cloud& cloud, std::size_t first, std::size_t step) {
  Cloud part((cloud.count - first + step - 1) / step, cloud.colored);
  for (std::size_t i = first, to = 0; i < cloud.count; i += step, ++to) {
    part.place(to, cloud.plane[0][i], cloud.plane[1][i], cloud.plane[2][i]);
    for (std::size_t c = 0; c < 3; ++c) part.color[c][to] = cloud.color[c][i];
    part.alpha[to] = cloud.alpha[i];
  }
  return part;
}

View small_view(int width, int height) {
  View view;
  view.width = width;
  view.height = height;
  view.camera.position = {0, 0, 10};
  view.background = {0.01f, 0.02f, 0.05f};
  return view;
}

std::vector<const ProjectLanes*> usable_project_lanes() {
  return test::runnable<ProjectLanes>(MOTES_BUILDS(project_lanes));
}
std::vector<const SplatLanes*> usable_splat_lanes() { return test::runnable<SplatLanes>(MOTES_BUILDS(splat_lanes)); }

std::vector<std::byte> projected(const Drawn& drawn, const Sprite& sprite, const View& view,
                                 const Projection& projection, const ProjectLanes& lanes,
                                 const ProjectWideLanes& wide) {
  Projector projector(lanes, wide);
  Records records;
  projector.project(drawn, sprite, view, records, projection);
  return {records.bytes().begin(), records.bytes().end()};
}

std::vector<std::byte> message(const Cloud& cloud, const Sprite& sprite, const View& view, const ProjectLanes& lanes) {
  return projected(cloud.drawn(), sprite, view, {}, lanes);
}

Pixels picture(const View& view, const std::vector<std::vector<std::byte>>& messages, const SplatLanes& lanes) {
  Canvas canvas(lanes);
  canvas.begin(view);
  for (const auto& m : messages) canvas.add(m);
  return canvas.finish();
}

std::vector<float> linear_of(const std::vector<std::uint32_t>& sums) {
  std::vector<float> linear(sums.size());
  for (std::size_t i = 0; i < sums.size(); ++i) linear[i] = static_cast<float>(sums[i] / double{kUnit});
  return linear;
}

std::vector<float> light_of(const TilePainter& painter, const Area& area) {
  const auto row = static_cast<std::size_t>(3 * area.width);
  std::vector<std::uint32_t> sums(row * static_cast<std::size_t>(area.height));
  painter.light().copy_to(sums.data(), row);
  return linear_of(sums);
}

}  // namespace motes::image_test
