// How a mesh deforms during a frame: from one form to another with the same triangles.
#pragma once

#include "meshes/mesh_form.h"

namespace motes::meshes {

/// Returns how `before` deforms into `now`: two kept forms of meshes with equal triangles. Made once per pair and kept
/// until the process ends. Builds the inside of both: throws like need_inside(). Throws std::invalid_argument if the
/// triangles differ. Thread-safe.
const Deformation* deformation_of(const MeshForm& before, const MeshForm& now);

}  // namespace motes::meshes
