// SPDX-License-Identifier: MPL-2.0
// The data behind the types Mesh and Deformer.
#pragma once

#include <array>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "batten/core/call_serializer.h"
#include "batten/mesh/deform/form_feature_deformer.h"
#include "batten/scenes/mesh.h"
#include "batten/scenes/meshes/edit_session.h"

namespace batten::detail {

/// A mesh with its file, if any. Immutable: copies of a Mesh share it.
struct SharedMesh {
  /// The mesh of a file.
  explicit SharedMesh(MeshSource read);
  /// A mesh without a file. Throws as the constructor of Mesh.
  explicit SharedMesh(ShellMesh shells, std::vector<MeshSet> named = {});

  const ShellMesh& shells() const { return source.file.shells(); }
  /// The mesh for computations. Its first vertices are the nodes of shells(), see PreparedMesh.
  const TriangleMesh& mesh() const { return source.prepared.mesh; }
  const MeshTopology& topology() const { return mesh().topology(); }
  const std::vector<MeshSet>& sets() const { return of_file ? source.file.sets() : own_sets; }
  /// Triangles of nodes, without duplicate vertices.
  const std::vector<std::array<int, 3>>& node_triangles() const;

  MeshSource source;
  bool of_file;
  std::vector<MeshSet> own_sets;  ///< sets of a mesh without a file
  Points corner_normals;          ///< Mesh::corner_normals()

 private:
  void find_node_triangles();
  std::vector<std::array<int, 3>> node_triangles_;  // empty if there are no duplicate vertices
};

/// A deformer, its mesh and its settings.
struct DeformerState {
  DeformerState(const Mesh& of, const DeformerSettings& given);

  const DeformProblem& problem() const { return linear ? linear->problem() : editor->problem(); }
  /// All vertices after the last edit; always the same memory.
  const Points& positions() const { return linear ? linear->positions() : shape; }
  /// `correct`: correct rounding errors. Throws the exceptions of Deformer::deform().
  void deform(const DeformEdit& edit, bool correct);

  Mesh mesh;
  DeformerSettings settings;
  std::unique_ptr<FormFeatureDeformer> linear;  ///< for RotationMode::Harmonic
  std::unique_ptr<MeshEditor> editor;           ///< for the other rotation modes
  Points shape;                                 ///< result of `editor`
  double residual = 0;                          ///< of `shape`
  std::vector<Vec3> origins;                    ///< one of each point constraint
  DeformerReport report;
  DeformEdit last;            ///< of the last deform()
  bool last_correct = false;  ///< its argument
  CallSerializer serialize;   ///< of the calls of `deform`
};

/// The index of an object with a name. Throws InputError for a name that none has, with the nearest
/// one. `what`, `kind`: argument and kind of the object, for messages.
template <class Named>
size_t index_of_name(const std::string& name, const std::vector<Named>& all,
                     const std::string& what, const std::string& kind) {
  std::vector<std::string> names;
  for (size_t i = 0; i < all.size(); ++i) {
    if (all[i].name == name) return i;
    names.push_back(all[i].name);
  }
  throw InputError(what + ": found '" + name + "', expected a " + kind + "'s name" +
                   did_you_mean(name, names));
}

/// A move as the transformation of a handle, about the origin unless Move::about is given. Throws
/// InputError if the axis has length 0.
HandleTransform transform_of(const Move& move);

/// The transformations of all handles, in their order; handles without a move stay where they are.
/// Throws InputError for a name that is none of a handle, with the nearest one, and as
/// transform_of().
std::vector<HandleTransform> transforms_of(const std::map<std::string, Move>& moves,
                                           const std::vector<Handle>& handles,
                                           const TriangleMesh& mesh);

}  // namespace batten::detail
