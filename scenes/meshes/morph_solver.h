// SPDX-License-Identifier: MPL-2.0
// The edits of a deform scene, solved repeatedly for changing parameter values.
#pragma once

#include <memory>
#include <vector>

#include "batten/core/progress.h"
#include "batten/io/scene/deform_scene.h"
#include "batten/mesh/attached/attached_nodes.h"
#include "batten/scenes/meshes/edit_session.h"
#include "batten/scenes/meshes/vertex_selector.h"

namespace batten {

/// Solves the edits of a deform scene in order, each on the result of the previous one, for changing
/// parameter values:
///
///     const MeshSource source = read_source(scene.mesh);
///     MorphSolver solver(scene, source);
///     solver.solve(scene);
///     scene.set("edit.right.x", 20, "");
///     const Points& longer = solver.solve(scene);
///
/// The edits before the first one with changed values are kept. This one keeps its factorization, so
/// that a change of the only edit costs no factorization (except for scaled features); the later ones
/// start from another shape, and are factored again. A change of the values of a [[constraint]],
/// [[position_constraint]] or [[curve]], which all edits share, concerns all edits.
class MorphSolver {
 public:
  /// Keeps a reference to `source`. Selections are evaluated when they are needed. `tolerance`:
  /// MeshEditorOptions::tolerance; kDerivativeTolerance for derivatives.
  MorphSolver(DeformScene scene, const MeshSource& source,
              double tolerance = MeshEditorOptions().tolerance);
  MorphSolver(const MorphSolver&) = delete;
  MorphSolver& operator=(const MorphSolver&) = delete;

  /// Positions of all vertices (n×3) after all edits. `values`: the scene of the constructor with
  /// other parameter values. Throws InputError for unknown names or an unsolvable problem,
  /// ConflictError, NoSolutionError and CancelledError; scene and shape are then those of the last
  /// successful call, or without edits if there is none.
  const Points& solve(const DeformScene& values, const Progress& progress = {});

  /// The scene, with the values of the last solve().
  const DeformScene& scene() const { return scene_; }
  const MeshSource& source() const { return source_; }
  double tolerance() const { return tolerance_; }
  /// The mesh before the edits.
  const TriangleMesh& mesh() const { return source_.prepared.mesh; }
  /// Positions of all vertices after the last edit (n×3).
  const Points& shape() const { return edits_.empty() ? mesh().points() : edits_.back()->shape(); }
  /// Positions of all vertices before the first edit, and after each edit.
  std::vector<Points> states() const;
  /// The edits in order, each with its solution.
  const std::vector<std::unique_ptr<EditSession>>& edits() const { return edits_; }

  VertexSelector& select() { return select_; }
  /// Nodes of elements that are not shells.
  const AttachedNodes& attached() const { return attached_; }
  /// Features and constraints of all edits; empty before the first solve().
  const SharedConstraints& shared() const { return shared_; }

 private:
  struct Backup;
  size_t first_changed_edit(const DeformScene& values) const;
  void solve_from(size_t first, const DeformScene& values, const Progress& progress);
  void restore(Backup& backup);

  DeformScene scene_;
  const MeshSource& source_;
  double tolerance_;
  VertexSelector select_;
  AttachedNodes attached_;
  SharedConstraints shared_;
  bool gathered_ = false;  // shared_ is that of scene_
  std::vector<std::unique_ptr<EditSession>> edits_;
};

}  // namespace batten
