// Meshes as shapes: what is made of each, once per process and kept until it ends.
#pragma once

#include "meshes/assets.h"
#include "meshes/mesh_form.h"

namespace motes::meshes {

/// The surface of a kept mesh, for a grid of so many cells along its longest side; with its volume where it is `solid`:
/// unions share samples out by it, also where nobody has needed the inside yet. Null where this process keeps no such
/// mesh, or the resolution is not allowed. Thread-safe, as is the next one.
const MeshForm* form_of(AssetKey mesh, int resolution, bool solid);

/// Builds the signed distance field, unless it is there already. Throws std::invalid_argument, saying what is wrong,
/// where the surface has no inside.
void need_inside(const MeshForm& form);

}  // namespace motes::meshes
