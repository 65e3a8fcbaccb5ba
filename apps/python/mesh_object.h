// A mesh as Python holds it.
#pragma once

#include <memory>

#include "batten/apps/commands/meshes/mesh_source.h"
#include "batten/apps/python/bindings.h"

namespace batten::python {

/// A mesh of a file, or of arrays, ready for deformers. It does not change.
struct MeshObject {
  MeshSource source;
  bool of_file = false;
};

/// A mesh of points n×3 and triangles m×3. Throws InputError, MeshError.
std::shared_ptr<MeshObject> mesh_of_arrays(const py::object& points, const py::object& triangles);

/// The Mesh that was given, or that of points and triangles.
std::shared_ptr<const MeshObject> mesh_from(const py::object& mesh_or_points,
                                            const py::object& triangles);

}  // namespace batten::python
