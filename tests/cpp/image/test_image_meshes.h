// Meshes for the image tests.
#pragma once

#include "meshes/assets.h"

namespace motes::image_test {

/// Returns a ball of radius 1 around (0, 1, 0): an octahedron whose triangles are divided `times` times into four.
meshes::Mesh ball_mesh(int times);

}  // namespace motes::image_test
