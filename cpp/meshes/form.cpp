#include "meshes/form.h"

#include <sched.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <mutex>
#include <stdexcept>

#include "base/invalid_argument.h"
#include "base/vectors.h"
#include "meshes/distance_field.h"
#include "simd/float_mode.h"

namespace motes::meshes {
namespace {

Vector corner(const Mesh& mesh, std::size_t index) {
  const float* v = mesh.vertices.data() + 3 * std::size_t{mesh.triangles[index]};
  return {v[0], v[1], v[2]};
}

double area_of(const Mesh& mesh, std::size_t first) {
  const Vector a = corner(mesh, first);
  return 0.5 * length(cross(corner(mesh, first + 1) - a, corner(mesh, first + 2) - a));
}

// Everything that a form points to.
struct FormEntry {
  AssetKey mesh = 0;
  int resolution = 0;
  std::vector<float> corners, colors;
  std::vector<std::uint32_t> upto;
  std::mutex building;
  DistanceField grid;
  std::vector<std::uint32_t> cells;
  bool has_volume = false;
  MeshForm form;
};

// Adds a triangle, starting with corner number `turn`.
void add_triangle(FormEntry& entry, const Mesh& mesh, std::size_t triangle, std::size_t turn) {
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t vertex = 3 * std::size_t{mesh.triangles[triangle + (turn + k) % 3]};
    const auto add = [vertex](const std::vector<float>& of, std::vector<float>& to) {
      if (!of.empty()) to.insert(to.end(), of.data() + vertex, of.data() + vertex + 3);
    };
    add(mesh.vertices, entry.corners);
    add(mesh.colors, entry.colors);
  }
}

void set_surface(FormEntry& entry, const Mesh& mesh) {
  MeshForm& form = entry.form;
  std::vector<double> sums;
  double sum = 0;
  form.uneven = !mesh.density.empty();
  for (std::size_t first = 0; first + 2 < mesh.triangles.size(); first += 3) {
    const double area = area_of(mesh, first);
    if (!(area > 0)) continue;
    form.area += area;
    for (std::size_t k = 0; k < (form.uneven ? 3 : 1); ++k) {
      const double births = form.uneven ? area * mesh.density[mesh.triangles[first + k]] : area;
      if (!(births > 0)) continue;
      sums.push_back(sum += births);
      add_triangle(entry, mesh, first, k);
    }
  }
  for (const double upto : sums) entry.upto.push_back(static_cast<std::uint32_t>(upto / sum * 0xffffffffu));
  if (!entry.upto.empty()) entry.upto.back() = 0xffffffffu;
  form.corners = entry.corners.data();
  form.colors = entry.colors.empty() ? nullptr : entry.colors.data();
  form.upto = entry.upto.data();
  form.triangles = static_cast<std::uint32_t>(entry.upto.size());
}

void set_volume(FormEntry& entry, const Mesh& mesh) {
  entry.form.volume = std::fabs(volume(weld(mesh)));
  entry.has_volume = true;
}

// Returns how many threads of this process may run at once. Ranks of one host that build at the same time share its
// processors.
int threads_for_building() {
  cpu_set_t allowed;
  const bool known = ::sched_getaffinity(0, sizeof allowed, &allowed) == 0;
  return std::clamp(known ? CPU_COUNT(&allowed) : 1, 1, 16);
}

void set_inside(FormEntry& entry) {
  const Surface surface = weld(*mesh(entry.mesh));
  const std::string wrong = opening(surface);
  if (!wrong.empty()) {
    throw base::InvalidArgument("its surface", "be closed, to have an inside", wrong, "Mesh");
  }
  try {
    threads::Pool pool(threads_for_building());
    entry.grid = distance_grid(surface, entry.resolution, pool);
  } catch (const threads::NoThread&) {
    entry.grid = distance_grid(surface, entry.resolution, threads::alone());
  }
  entry.cells = inner_cells(entry.grid);
  MeshForm& form = entry.form;
  std::copy_n(entry.grid.nodes.data(), 3, form.nodes);
  std::copy_n(entry.grid.low.data(), 3, form.first);
  form.cell = entry.grid.cell;
  form.cells = entry.cells.data();
  form.cell_count = static_cast<std::uint32_t>(entry.cells.size());
  form.distance = entry.grid.distance.data();
}

std::mutex& lock() {
  static std::mutex mutex;
  return mutex;
}

using Name = std::pair<AssetKey, int>;
std::map<Name, std::unique_ptr<FormEntry>>& all() {
  static std::map<Name, std::unique_ptr<FormEntry>> forms;
  return forms;
}

FormEntry& entry_of(const MeshForm& form) {
  const std::scoped_lock held(lock());
  const auto found =
      std::find_if(all().begin(), all().end(), [&](const auto& entry) { return &entry.second->form == &form; });
  if (found == all().end()) throw std::invalid_argument("Mesh: this process keeps no such mesh");
  return *found->second;
}

}  // namespace

const MeshForm* form_of(AssetKey mesh, int resolution, bool solid) {
  if (resolution < kLeastResolution || resolution > kMostResolution || !has_mesh(mesh)) return nullptr;
  const simd::FloatMode mode;
  const std::scoped_lock held(lock());
  std::unique_ptr<FormEntry>& entry = all()[{mesh, resolution}];
  if (entry == nullptr) {
    entry = std::make_unique<FormEntry>();
    entry->mesh = mesh;
    entry->resolution = resolution;
    set_surface(*entry, *meshes::mesh(mesh));
  }
  if (solid && !entry->has_volume) set_volume(*entry, *meshes::mesh(mesh));
  return &entry->form;
}

std::shared_ptr<const Mesh> mesh_of(const MeshForm& form) { return mesh(entry_of(form).mesh); }

void need_inside(const MeshForm& form) {
  FormEntry& entry = entry_of(form);
  const simd::FloatMode mode;
  const std::scoped_lock held(entry.building);
  if (form.distance == nullptr) set_inside(entry);
}

}  // namespace motes::meshes
