// Closed meshes that the tests of meshes share, and what is known of them.
#pragma once

#include "meshes/assets.h"

namespace test {

/// A ball around the origin, as a formula gives it: the seam is there twice, and each pole once per meridian.
motes::meshes::Mesh globe(int parallels, int meridians, double radius = 1);

/// A ring around the y axis.
motes::meshes::Mesh torus(int around, int across, double radius = 1, double tube = 0.4);

/// An axis-aligned box, facing outwards, or inwards.
motes::meshes::Mesh block(double low, double high, bool inwards = false);

/// Four corners of a cube: all edges are sharp.
motes::meshes::Mesh tetrahedron();

/// Both, as one mesh.
motes::meshes::Mesh together(const motes::meshes::Mesh& a, const motes::meshes::Mesh& b);

/// Signed distance, found by trying each triangle; the sign by the solid angle under which all of them are seen.
double distance_by_trying(const motes::meshes::Mesh& mesh, double x, double y, double z);

}  // namespace test
