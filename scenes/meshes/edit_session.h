// SPDX-License-Identifier: MPL-2.0
// A deform scene as deformation problems: its mesh, the constraints that all edits share, the task of
// each edit, and a session that solves one edit repeatedly for changing values.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "batten/io/meshes/mesh_file.h"
#include "batten/mesh/attached/attached_nodes.h"
#include "batten/mesh/deform/deform_problem.h"
#include "batten/mesh/editing/mesh_editor.h"
#include "batten/mesh/editing/target_follower.h"
#include "batten/mesh/prepared_mesh.h"
#include "batten/scenes/meshes/vertex_selector.h"
#include "batten/sculpting/curves/deformable_curve.h"
#include "batten/skinning/target/target_surface.h"

namespace batten {

/// A mesh file, and its prepared (clean, oriented) triangle mesh.
struct MeshSource {
  MeshFile file;
  PreparedMesh prepared;
};

/// Reads and prepares a mesh. Throws InputError that begins with the file name.
MeshSource read_source(const std::filesystem::path& path);

/// Positions of the file's nodes. The mesh may have more vertices than nodes: nodes on non-manifold
/// edges are split per manifold patch.
Points node_positions(const Points& vertices, const MeshFile& file);

// Data that all edits of a deform scene share.

/// A chain of vertices with the curve that drives it.
struct MeshCurve {
  std::string name;
  std::vector<int> vertices;
  SculptedCurve shape;
};

/// Constraints that all edits of a scene share: features, guides, chains and linear constraints.
struct SharedConstraints {
  std::vector<FormFeature> features;
  const AttachedNodes* attached = nullptr;         ///< its connections are features, too
  std::vector<VertexCombination> centres;          ///< centre of each feature
  std::vector<std::vector<int>> shared_rotations;  ///< groups of features that rotate equally
  std::vector<PointConstraint> point_constraints;
  std::vector<std::optional<Vec3>> through;  // GuideSpec::through of each guide
  std::vector<CharacterChain> chains;
  std::vector<LinearConstraint> rows;
  std::vector<MeshCurve> curves;
  std::vector<TargetFollower> targets;                         ///< how the mesh follows surfaces
  std::vector<std::shared_ptr<const TargetSurface>> surfaces;  ///< of `targets`
  std::vector<std::string> notes;                              // remarks for the user
  std::vector<std::vector<int>> lines;  // vertices of chains and curves, for pictures; closed
                                        // chains repeat the first vertex
};

/// Checks a chain that keeps its shape approximately, and replaces the width 0 by the default, a
/// tenth of its length. Throws InputError unless the chain has three or more vertices, each once.
CharacterChain with_default_width(CharacterChain chain, const TriangleMesh& mesh);

/// Largest distance of the vertices, at positions p (n×3), from the curve.
double distance_from(const MeshCurve& curve, const Points& p);

/// Collects the shared constraints, without targets. Throws InputError, with the location, for unknown names.
SharedConstraints gather_shared_constraints(const DeformScene& scene, VertexSelector& select,
                                            const AttachedNodes& attached,
                                            const TriangleMesh& mesh);

/// Vertices of a feature, a selection or a proposal. Throws InputError, with the location, for an
/// unknown name.
std::vector<int> vertices_of(const LocatedString& name, const SharedConstraints& shared,
                             VertexSelector& select);

/// The problem of one edit and its prescribed motion.
struct DeformTask {
  DeformProblem problem;
  DeformEdit edit;
};

/// The prescribed motion of an edit. `mesh`: result of the previous edit. Throws InputError, with
/// the location, for an unknown feature or guide.
DeformEdit edit_of(const DeformScene& scene, const EditSpec& rule, const SharedConstraints& shared,
                   const DeformProblem& problem, const TriangleMesh& mesh);

/// Creates the task of one edit. `mesh`: result of the previous edit. Throws InputError, with the
/// location, for an unknown name.
DeformTask make_deform_task(const DeformScene& scene, const EditSpec& rule,
                            const SharedConstraints& shared, VertexSelector& select,
                            const TriangleMesh& mesh);

/// One [[edit]] of the shape that the previous edit left: a MeshEditor whose problem and values are
/// those of the scene. Exceptions name the edit and its location in the scene.
class EditSession {
 public:
  /// Keeps references to all arguments but `rule` and `before`. Throws InputError for unknown names or
  /// an unsolvable problem, and NoSolutionError. `tolerance`: MeshEditorOptions::tolerance.
  EditSession(const DeformScene& scene, const EditSpec& rule, const SharedConstraints& shared,
              VertexSelector& select, const PreparedMesh& prepared, const Points& before,
              double tolerance = MeshEditorOptions().tolerance);

  /// Changes the values of the edit: translations, rotations and scales of handles, scales of
  /// features, points of constraints. The values of the shared constraints are read again, too.
  void set(const EditSpec& rule);
  /// The edit with its current values.
  const EditSpec& rule() const { return rule_; }

  /// The shape during a drag. Throws the exceptions of solve_to_equilibrium(); the shape is then
  /// unchanged.
  const Points& solve_preview();
  /// True if features rotated by less than 0.05 degrees in the last solution.
  bool is_at_rest() const { return editor_->is_at_rest(); }
  /// The converged shape: all vertices, including attached nodes. Throws InputError, ConflictError,
  /// NoSolutionError; the shape is then unchanged.
  const Points& solve_to_equilibrium();
  /// Statistics of the last solve_to_equilibrium().
  const MeshEditStatistics& statistics() const { return editor_->statistics(); }

  /// The shape of the last solve_preview() or solve_to_equilibrium().
  const Points& shape() const { return editor_->shape(); }
  /// The problem and the prescribed motion.
  DeformTask task() const { return {editor_->problem(), editor_->edit()}; }
  /// Sentences about parts of the mesh that nothing moves or fixes.
  std::vector<std::string> notes() const { return editor_->notes(); }

 private:
  template <class Function>
  void with_edit_context(const Function& f) const;
  DeformTask task_at(const Points& before);
  void build(const Points& before, DeformTask task);
  DeformEdit current_edit() const;
  void move_springs(const Points& shape);
  Points shape_on_targets();
  void follow_targets();

  const DeformScene& scene_;
  EditSpec rule_;
  const SharedConstraints& shared_;
  VertexSelector& select_;
  const PreparedMesh& prepared_;
  double tolerance_;
  std::vector<TargetFollower> followers_;  // of the targets, each with its current vertices
  std::vector<Vec3> spring_ends_;          // of all followers
  std::vector<Vec3> tie_targets_;      // constraints of attached nodes, which follow the springs
  std::unique_ptr<MeshEditor> plain_;  // without features, to follow the targets
  std::unique_ptr<MeshEditor> editor_;
};

}  // namespace batten
