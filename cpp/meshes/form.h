// Meshes as shapes: the data derived from each, made once per process and kept until it ends.
#pragma once

#include "meshes/assets.h"
#include "meshes/mesh_form.h"

namespace motes::meshes {

/// Returns the form of a kept mesh with its surface, for a grid of `resolution` cells along its longest side. `solid`:
/// with its volume, by which unions distribute samples, even if the inside has not been needed yet. Null if this
/// process keeps no such mesh or the resolution is not allowed. Thread-safe.
const MeshForm* form_of(AssetKey mesh, int resolution, bool solid);

/// Returns the mesh of a form. Throws std::invalid_argument if the process keeps no such form. Thread-safe.
std::shared_ptr<const Mesh> mesh_of(const MeshForm& form);

/// Builds the signed distance field, unless it exists already. Throws std::invalid_argument, saying what is wrong, if
/// the surface has no inside. Thread-safe.
void need_inside(const MeshForm& form);

}  // namespace motes::meshes
