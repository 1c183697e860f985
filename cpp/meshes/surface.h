// The triangles of a mesh as one surface: vertices at the same position are merged, and edges know their two sides.
//
// Everything here and in distance_field.h is computed by + - * / and sqrt in double precision, in an order that depends
// only on the mesh, so the bits are the same in every process.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "base/vectors.h"
#include "meshes/assets.h"

namespace motes::meshes {

struct Surface {
  std::vector<Vector> vertices;  // m
  std::vector<std::array<std::uint32_t, 3>> triangles;  // of three different vertices each
  std::vector<std::uint32_t> origin{};  // number of each triangle in the mesh
};

/// Merges vertices that are closer than a millionth of the mesh's extent: files and formulas repeat those of seams and
/// poles. Triangles that lose a corner are left out.
Surface weld(const Mesh& mesh);

/// Returns why the surface has no inside: how many edges are open, have more than two triangles, or are between
/// triangles that face opposite sides, and where the first one is. Empty if it has an inside.
std::string opening(const Surface& surface);

/// Returns the volume, m^3; negative if the triangles face inwards.
double volume(const Surface& surface);

/// Outward directions, of any length, at all places of a closed surface. At edges and vertices they are sums over the
/// adjacent triangles, at vertices weighted by angle, so the sign of the distance is right there, too (J. A. Baerentzen
/// and H. Aanaes, 2005). Slivers, whose direction is noise, add nothing.
struct Normals {
  std::vector<Vector> triangle;  // unit; zero for a sliver
  std::vector<std::array<Vector, 3>> edge;  // of each triangle: from its corner k to corner k + 1
  std::vector<Vector> vertex;
};
Normals normals_of(const Surface& surface);

}  // namespace motes::meshes
