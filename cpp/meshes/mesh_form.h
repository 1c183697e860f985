// What a kernel needs of a mesh: plain pointers into memory that stays until the process ends.
#pragma once

#include <cstdint>

namespace motes::meshes {

struct MeshForm {
  // The surface: triangles with an area. Where it is uneven, each is there up to three times, with another corner
  // first: of its births as many as that corner's density adds, and the nearer to it the more.
  bool uneven = false;
  const float* corners = nullptr;        // m, nine numbers of each triangle
  const float* colors = nullptr;   // linear RGB, nine numbers of each triangle; null: it has none
  const std::uint32_t* upto = nullptr;  // a number of 32 bits selects the first triangle whose `upto` is not below it
  std::uint32_t triangles = 0;
  double area = 0;  // m^2
  double volume = 0;  // m^3, once a shape is drawn from the inside

  // The inside, once it is needed: the distance at the nodes of a grid, x fastest.
  const float* distance = nullptr;  // m, negative inside
  std::int32_t nodes[3] = {};
  float first[3] = {};  // m, the place of the first node
  float cell = 0;  // m
  const std::uint32_t* cells = nullptr;  // those with a corner inside, by the numbers of their first nodes
  std::uint32_t cell_count = 0;
};

}  // namespace motes::meshes
