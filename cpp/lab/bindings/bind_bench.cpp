#include "bindings/bindings.h"
#include "lab/bench/bench_actions.h"
#include "lab/bench/bench_births.h"
#include "lab/bench/bench_image.h"
#include "lab/bench/bench_meshes.h"
#include "lab/bench/bench_pictures.h"
#include "lab/bench/bench_program.h"
#include "lab/bench/bench_scenery.h"

namespace motes::bindings {
namespace {

void bind_scenes(py::module_& m) {
  m.def(
      "act_bench",
      [](const std::string& scene, std::size_t particles, int steps) {
        const auto b = released([&] { return bench::act_bench(scene, particles, steps); });
        py::dict d;
        d["updates_per_s"] = b.updates_per_s;
        d["memory_limit_updates_per_s"] = b.memory_limit_updates_per_s;
        d["ratio"] = b.ratio;
        d["bytes_per_particle"] = b.bytes_per_particle;
        return d;
      },
      py::arg("scene"), py::arg("particles"), py::arg("steps"));
  m.def(
      "leaver_bench",
      [](std::size_t particles, int bins, int steps) {
        const auto b = released([&] { return bench::leaver_bench(particles, bins, steps); });
        py::dict d;
        d["none_s"] = b.none;
        d["fused_s"] = b.fused;
        d["scanned_s"] = b.scanned;
        d["binned_s"] = b.binned;
        return d;
      },
      py::arg("particles"), py::arg("bins"), py::arg("steps"));
}

void bind_actions(py::module_& m) {
  m.def(
      "action_bench",
      [](std::size_t particles, int repeats) {
        const auto costs = released([&] { return bench::action_bench(particles, repeats); });
        py::dict all;
        for (const bench::ActionCost& c : costs) {
          py::dict d;
          d["alone_ns"] = c.alone;
          d["added_ns"] = c.added;
          d["memory_limit_ns"] = c.memory_limit;
          d["alone_in_cache_ns"] = c.alone_in_cache;
          d["added_in_cache_ns"] = c.added_in_cache;
          d["bytes_loaded"] = c.bytes_loaded;
          d["bytes_stored"] = c.bytes_stored;
          all[py::str(c.action)] = d;
        }
        return all;
      },
      py::arg("particles"), py::arg("repeats"));
  m.def(
      "list_bench",
      [](std::size_t particles, int steps) {
        const auto b = released([&] { return bench::list_bench(particles, steps); });
        py::dict d;
        for (const auto& list : b.lists) {
          d[(list.name + "_s").c_str()] = list.seconds;
          d[(list.name + "_in_cache_s").c_str()] = list.in_cache;
          d[(list.name + "_of_limit").c_str()] = list.of_limit;
          d[(list.name + "_of_roofline").c_str()] = list.of_roofline;
        }
        d["limit_s"] = b.limit;
        d["twelve_by_five"] = b.ratio;
        return d;
      },
      py::arg("particles"), py::arg("steps"));
  m.def(
      "mesh_bench",
      [](std::size_t particles, int repeats) {
        const auto b = released([&] { return bench::mesh_bench(particles, repeats); });
        py::dict d;
        d["triangles"] = b.triangles;
        d["grid_bytes"] = b.grid_bytes;
        d["build_s"] = b.build_s;
        d["spread_ns"] = b.spread;
        d["near_ns"] = b.near;
        d["away_ns"] = b.away;
        d["sphere_ns"] = b.ball;
        d["spread_by_sphere"] = b.ratio;
        return d;
      },
      py::arg("particles"), py::arg("repeats"));
}

void bind_births(py::module_& m) {
  m.def(
      "birth_bench",
      [](int calculators, int births, int repeats) {
        const auto b = released([&] { return bench::birth_bench(calculators, births, repeats); });
        py::dict d;
        d["make_ns"] = b.make;
        d["own_ns"] = b.own;
        d["pack_ns"] = b.pack;
        d["forward_ns"] = b.forward;
        d["take_ns"] = b.take;
        d["run_ns"] = b.run;
        return d;
      },
      py::arg("calculators"), py::arg("births"), py::arg("repeats"));
}

void bind_pictures(py::module_& m) {
  m.def(
      "picture_bench",
      [](std::size_t particles, int width, int height, int repeats) {
        const auto b = released([&] { return bench::picture_bench(particles, width, height, repeats); });
        py::dict d;
        d["project_ns"] = b.project;
        d["record_ns"] = b.record;
        d["pixel_ns"] = b.pixel;
        d["bloom_pixel_ns"] = b.bloom_pixel;
        d["spread_pixel_ns"] = b.spread_pixel;
        d["partial_pixel_ns"] = b.partial_pixel;
        return d;
      },
      py::arg("particles"), py::arg("width"), py::arg("height"), py::arg("repeats"));
}

void bind_render(py::module_& m) {
  m.def(
      "render_bench",
      [](std::size_t particles, int width, int height, int pixels, int frames, bool fountain) {
        const auto b =
            released([&] { return bench::render_bench(particles, width, height, pixels, frames, fountain); });
        py::dict d;
        d["particles"] = b.particles;
        d["width"] = b.width;
        d["height"] = b.height;
        d["pixels"] = b.pixels;
        d["frames"] = b.frames;
        d["cores"] = 1;
        d["simd"] = b.isa;
        d["ms_per_frame"] = b.ms_per_frame;
        d["ms_per_frame_min"] = b.ms_per_frame_min;
        d["ms_project"] = b.ms_project;
        d["ms_splat"] = b.ms_splat;
        d["message_bytes"] = b.bytes;
        py::list rows;
        for (const bench::RenderRow& r : b.rows) {
          py::dict row;
          row["name"] = r.name;
          row["kind"] = r.kind;
          row["blend"] = r.blend;
          row["pixels"] = r.pixels;
          row["ms_per_frame"] = r.ms_per_frame;
          row["ms_project"] = r.ms_project;
          row["ratio"] = r.ratio;
          rows.append(row);
        }
        d["rows"] = rows;
        return d;
      },
      py::arg("particles"), py::arg("width"), py::arg("height"), py::arg("pixels"), py::arg("frames"),
      py::arg("fountain"));
}

void bind_scenery(py::module_& m) {
  m.def(
      "scenery_bench",
      [](int width, int height, int frames) {
        const auto b = released([&] { return bench::scenery_bench(width, height, frames); });
        py::dict d;
        d["width"] = b.width;
        d["height"] = b.height;
        d["frames"] = b.frames;
        d["cores"] = 1;
        d["simd"] = b.isa;
        d["ms_shapes"] = b.ms_shapes;
        d["ms_shapes_and_lights"] = b.ms_shapes_lights;
        d["ms_light_moves"] = b.ms_light_moves;
        d["mesh_triangles"] = b.triangles;
        d["ms_mesh"] = b.ms_mesh;
        d["ms_build_mesh"] = b.ms_build_mesh;
        return d;
      },
      py::arg("width"), py::arg("height"), py::arg("frames"));
}

}  // namespace

void bind_bench(py::module_& m) {
  bind_scenes(m);
  bind_actions(m);
  bind_births(m);
  bind_pictures(m);
  bind_render(m);
  bind_scenery(m);
}

}  // namespace motes::bindings
