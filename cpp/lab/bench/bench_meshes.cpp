#include "lab/bench/bench_meshes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "lab/bench/bench_scene.h"
#include "meshes/distance_field.h"
#include "meshes/form.h"
#include "program/program.h"

namespace motes::bench {
namespace {

using namespace recording;

using actions::Action;
using particles::Store;
using shapes::Shape;

constexpr int kResolution = 96, kParts = 72;
constexpr float kFrameS = 1.0f / 24;
constexpr float kSpeed = 2 * 2.0f / kResolution / kFrameS;  // two cells per step

meshes::Mesh globe() {
  constexpr double kPi = 3.14159265358979323846;
  meshes::Mesh mesh;
  for (int i = 0; i <= kParts; ++i) {
    for (int j = 0; j <= kParts; ++j) {
      const double down = kPi * i / kParts, turn = 2 * kPi * j / kParts;
      for (const double x : {std::sin(down) * std::cos(turn), std::cos(down), std::sin(down) * std::sin(turn)}) {
        mesh.vertices.push_back(static_cast<float>(x));
      }
    }
  }
  for (std::uint32_t i = 0; i < kParts; ++i) {
    for (std::uint32_t j = 0; j < kParts; ++j) {
      const std::uint32_t a = i * (kParts + 1) + j, b = a + kParts + 1;
      mesh.triangles.insert(mesh.triangles.end(), {a, b + 1, b, a, a + 1, b + 1});
    }
  }
  return mesh;
}

Shape shape_of(const meshes::Mesh& mesh) {
  float number[shapes::kNumbers] = {};
  number[3] = number[10] = 1;
  number[15] = kResolution;
  return shapes::mesh_shape(meshes::keep(mesh), number);
}

// Pseudorandom numbers in 0..1, of low quality.
class Numbers {
 public:
  float next() {
    state_ = state_ * 6364136223846793005u + 1442695040888963407u;
    return static_cast<float>(state_ >> 40) * 0x1p-24f;
  }

 private:
  std::uint64_t state_ = 1;
};

enum class Where { spread, near, away };

// Particles whose runs all start from the same positions and velocities.
class Crowd {
 public:
  Crowd(std::size_t count, Where where) : store_(schema_) {
    store_.grow(count);
    Numbers numbers;
    for (std::size_t i = 0; i < count; ++i) {
      store_.set_id(i, i);
      float place[3], way[3];
      do {
        for (int c = 0; c < 3; ++c) place[c] = 2.2f * numbers.next() - 1.1f, way[c] = 2 * numbers.next() - 1;
      } while (!(length(place) > 0.1f && length(way) > 0.1f));
      const float scale = where == Where::near ? (0.95f + 0.1f * numbers.next()) / length(place) : 1;
      for (int c = 0; c < 3; ++c) {
        start_[c].push_back(place[c] * scale + (where == Where::away ? 4.0f : 0.0f));
        velocity_[c].push_back(way[c] * kSpeed / length(way));
      }
    }
  }

  double run(const program::Program& program) {
    for (int c = 0; c < 3; ++c) {
      std::copy(start_[c].begin(), start_[c].end(), store_.writable_plane(particles::position, c));
      std::copy(velocity_[c].begin(), velocity_[c].end(), store_.writable_plane(particles::velocity, c));
    }
    program::ListResult outcome;
    const double start = cpu_now();
    program.run(store_, 0, 0, {0, 1, kFrameS, 0}, {1, 2}, {}, outcome);
    return 1e9 * (cpu_now() - start) / static_cast<double>(store_.size());
  }

 private:
  static float length(const float* v) { return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); }

  particles::Schema schema_;
  Store store_;
  std::vector<float> start_[3], velocity_[3];
};

program::Program bounce_off(const Shape& shape) {
  const Action action =
      actions::make(actions::numbers::bounce<>{.restitution = 0.5, .friction = 0.1, .exact_hit = 1}, {shape});
  actions::check(action);
  return program::Program({action});
}

double least_of(Crowd& crowd, const program::Program& program, int repeats) {
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i <= repeats; ++i) least = std::min(least, crowd.run(program));
  return least;
}

}  // namespace

MeshBench mesh_bench(std::size_t particles, int repeats) {
  if (particles == 0) throw std::invalid_argument("particles must be at least 1, got 0");
  if (repeats < 1) throw std::invalid_argument("repeats must be at least 1, got " + std::to_string(repeats));
  const meshes::Mesh mesh = globe();
  const meshes::Surface surface = meshes::weld(mesh);
  MeshBench bench;
  bench.triangles = surface.triangles.size();
  const double start = cpu_now();
  bench.grid_bytes = sizeof(float) * meshes::distance_grid(surface, kResolution, threads::alone()).distance.size();
  bench.build_s = cpu_now() - start;

  const program::Program off_mesh = bounce_off(shape_of(mesh));
  const program::Program off_ball = bounce_off(Shape{shapes::Kind::sphere, {0, 0, 0, 1, 0}});
  Crowd spread(particles, Where::spread), near(particles, Where::near), away(particles, Where::away);
  std::vector<double> ratios;
  bench.spread = bench.ball = std::numeric_limits<double>::infinity();
  for (int i = 0; i <= repeats; ++i) {
    const double mesh_ns = spread.run(off_mesh), ball_ns = spread.run(off_ball);
    bench.spread = std::min(bench.spread, mesh_ns);
    bench.ball = std::min(bench.ball, ball_ns);
    ratios.push_back(mesh_ns / ball_ns);
  }
  bench.near = least_of(near, off_mesh, repeats);
  bench.away = least_of(away, off_mesh, repeats);
  bench.ratio = median(ratios);
  return bench;
}

}  // namespace motes::bench
