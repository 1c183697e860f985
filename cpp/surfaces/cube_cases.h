// Marching cubes (W. Lorensen and H. Cline, 1987): the triangles in a cell by which of its corners are inside.
//
// Corner c is at (c & 1, c >> 1 & 1, c >> 2 & 1). Edge e = 4 * axis + k runs along `axis`; k has the other two
// coordinates of its place. On a face whose opposite corners are inside, these are kept apart; the neighbouring cell
// decides alike, so surfaces are closed. Each edge between two triangles belongs to exactly these two: a polygon that
// no inner diagonal divides gets a vertex at its centre.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace motes::surfaces {

struct CubeCase {
  /// Corners of triangles, three each: edges 0..11, and kCentre + i for the centre of polygons[i].
  std::vector<std::uint8_t> triangles;
  /// The polygons that have a vertex at their centre, as lists of edges.
  std::vector<std::vector<std::uint8_t>> polygons;
};

inline constexpr int kEdges = 12;
inline constexpr std::uint8_t kCentre = kEdges;

/// Returns the cases of all 256 sets of corners that are inside: bit c of the index is corner c.
const std::array<CubeCase, 256>& cube_cases();

/// Returns the corners of an edge: the one of the lower coordinate first.
std::array<int, 2> corners_of_edge(int edge);

}  // namespace motes::surfaces
