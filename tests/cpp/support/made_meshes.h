// Closed meshes for tests, and their known properties.
#pragma once

#include "meshes/assets.h"

namespace test {

/// Returns a ball around the origin, as a formula gives it: the seam has double vertices, each pole one per meridian.
motes::meshes::Mesh globe(int parallels, int meridians, double radius = 1);

/// Returns a ring around the y axis.
motes::meshes::Mesh torus(int around, int across, double radius = 1, double tube = 0.4);

/// Returns an axis-aligned box, facing outwards or inwards.
motes::meshes::Mesh block(double low, double high, bool inwards = false);

/// Returns four corners of a cube: all edges are sharp.
motes::meshes::Mesh tetrahedron();

/// Joins both meshes into one.
motes::meshes::Mesh together(const motes::meshes::Mesh& a, const motes::meshes::Mesh& b);

/// Returns the signed distance, found by trying each triangle; its sign is that of the solid angle of all of them.
double distance_by_trying(const motes::meshes::Mesh& mesh, double x, double y, double z);

}  // namespace test
