// SPDX-License-Identifier: MPL-2.0
// Reads surfaces that other surfaces are fitted to.
#pragma once

#include <filesystem>
#include <string>

#include "batten/skinning/mesh_targets/mesh_target.h"

namespace batten {

/// How a target file is read.
struct TargetFileOptions {
  std::string unit;           ///< length unit of the result
  std::string own_unit = {};  ///< length unit of a mesh file; empty: `unit`
  double chord = 0;           ///< chord tolerance of the triangles of CAD faces, in `unit`
  bool cage = false;          ///< the Catmull-Clark limit surface of the mesh
};

/// Appends the faces of a CAD file, as curved triangles, or of a mesh file. Throws InputError as the
/// readers do, and for a unit or a cage of a CAD file.
void append_target_file(TargetFaces& all, const std::filesystem::path& file,
                        const TargetFileOptions& options);

}  // namespace batten
