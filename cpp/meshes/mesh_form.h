// What a kernel needs of a mesh: plain pointers to memory that stays until the process ends.
#pragma once

#include <cstdint>

namespace motes::meshes {

struct MeshForm {
  // The surface: triangles with an area. If `uneven`, each is listed up to three times, with another corner first. Each
  // entry gets the births that its first corner's density adds, most of them near that corner.
  bool uneven = false;
  const float* corners = nullptr;        // nine numbers per triangle, m
  const float* colors = nullptr;   // linear RGB, nine numbers per triangle; null: no colours
  const std::uint32_t* upto = nullptr;  // a number of 32 bits selects the first triangle whose `upto` is not below it
  std::uint32_t triangles = 0;
  double area = 0;  // m^2
  double volume = 0;  // m^3, once a shape has needed it

  // The inside, once it is needed: the distance at the nodes of a grid, x fastest.
  const float* distance = nullptr;  // m, negative inside
  std::int32_t nodes[3] = {};
  float first[3] = {};  // position of the first node, m
  float cell = 0;  // m
  const std::uint32_t* cells = nullptr;  // cells with a corner inside, as the numbers of their first nodes
  std::uint32_t cell_count = 0;
};

}  // namespace motes::meshes
