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

/// How a mesh deforms during a frame. Its vertices move in straight lines; between them, displacements are interpolated
/// on a lattice, x fastest, and beyond it they are those at its border.
struct Deformation {
  const MeshForm* before = nullptr;  // at the start of the frame, with its inside
  const MeshForm* now = nullptr;  // at the end, with its inside
  // From start to end, m, one plane per axis: at places of the start, then at places of the end.
  const float* displacement[2][3] = {};
  std::int32_t nodes[3] = {};
  float first[3] = {};  // position of the first node, m
  float cell = 0;  // m
  float most = 0;  // length of the largest displacement, m
};

}  // namespace motes::meshes
