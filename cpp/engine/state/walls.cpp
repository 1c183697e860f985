#include "engine/state/walls.h"

#include <algorithm>
#include <map>
#include <string>
#include <utility>
#include <variant>

namespace motes::engine {

namespace {

using shapes::Shape;

// Appends the bytes of values that are equal if their numbers are: there is no -0.
template <class Part>
void put(const Part& part, base::Bytes& out) {
  out.put(part.kind);
  out.put(part.mesh);
  for (const float number : part.number) out.put(number + 0.0f);
}

// Returns bytes that equal shapes share.
std::string key_of(const Shape& shape) {
  base::Bytes bytes;
  put(shape, bytes);
  for (const shapes::UnionPart& part : shapes::parts_of(shape)) put(part, bytes);
  return {reinterpret_cast<const char*>(bytes.view().data()), bytes.size()};
}

constexpr int kPlace = shapes::kCountOf<shapes::MeshPlace>;  // first that at the frame's end, then that at its start

// Returns the key of a mesh without its place at the frame's start, or without any place.
template <int kFirst>
std::string key_without_places(Shape mesh) {
  std::fill(mesh.number + kFirst, mesh.number + 2 * kPlace, 0.0f);
  return key_of(mesh);
}

}  // namespace

void note_walls(Script& script, const Round& round) {
  if (!script.in_frame()) return;
  if (round.first == 0) script.walls.clear();
  std::map<std::string, std::size_t> known;
  for (std::size_t w = 0; w < script.walls.size(); ++w) known.emplace(key_of(script.walls[w].shape), w);
  auto next = round.verdict.walls.begin();
  for (std::size_t i = round.first; i < round.last; ++i) {
    const std::vector<recording::Item>& list = script.systems[i]->list;
    for (std::size_t item = 0; item < list.size(); ++item) {
      const auto* action = std::get_if<actions::Action>(&list[item]);
      const auto* grains = action != nullptr ? actions::grains_of(*action) : nullptr;
      for (std::size_t wall = 0; grains != nullptr && wall < grains->walls.size(); ++wall) {
        const auto [found, is_new] = known.emplace(key_of(action->shapes[wall]), script.walls.size());
        if (is_new) script.walls.push_back({action->shapes[wall], {}});
        const bool pressed =
            next != round.verdict.walls.end() && next->system == i && next->item == item && next->wall == wall;
        if (pressed) script.walls[found->second].sum += (next++)->sum;
      }
    }
  }
}

std::optional<std::array<double, 6>> force_on(const Script& script, const Shape& wall, int substeps) {
  const auto only = [&](const auto& key) -> const PressedWall* {
    const auto same = [&, wanted = key(wall)](const PressedWall& one) {
      return one.shape.kind == wall.kind && key(one.shape) == wanted;
    };
    const auto pressed = std::find_if(script.walls.begin(), script.walls.end(), same);
    if (pressed == script.walls.end() || std::any_of(pressed + 1, script.walls.end(), same)) return nullptr;
    return &*pressed;
  };
  const PressedWall* pressed = only(key_of);
  if (wall.kind == shapes::Kind::mesh) {
    if (pressed == nullptr) pressed = only(key_without_places<kPlace>);
    if (pressed == nullptr) pressed = only(key_without_places<0>);
    if (pressed == nullptr) pressed = only([](const Shape& mesh) { return mesh.origin; });  // with other vertices
  }
  if (pressed == nullptr) return std::nullopt;
  return mean_of(pressed->sum, substeps);
}

std::array<double, 6> mean_of(const interactions::WallSum& sum, int substeps) {
  std::array<double, 6> mean;
  for (std::size_t c = 0; c < 3; ++c) {
    mean[c] = sum.force[c].rounded() / substeps;
    mean[3 + c] = sum.torque[c].rounded() / substeps;
  }
  return mean;
}

}  // namespace motes::engine
