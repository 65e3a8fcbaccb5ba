// One edit of a deform scene, factored once and solved repeatedly for changing values.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "batten/apps/commands/meshes/deform_task.h"
#include "batten/io/report/deform_report.h"
#include "batten/mesh/editing/mesh_editor.h"

namespace batten {

/// One [[edit]] of the shape that the previous edit left: a MeshEditor whose problem and values are
/// those of the scene. Exceptions name the edit and its location in the scene.
class EditSession {
 public:
  /// Keeps references to the scene, `shared` and the mesh. Throws InputError for unknown names or
  /// an unsolvable problem, and NoSolutionError.
  EditSession(const DeformScene& scene, const EditSpec& rule, const SharedConstraints& shared,
              VertexSelector& select, const PreparedMesh& prepared, const Points& before);

  /// Changes the values of the edit: translations, rotations and scales of handles, scales of
  /// features.
  void set(const EditSpec& rule);
  /// The edit with its current values.
  const EditSpec& rule() const { return rule_; }

  /// The shape during a drag. Throws the exceptions of solve_to_equilibrium(); the shape is then
  /// unchanged.
  const Points& solve_preview();
  /// True if features rotated by less than 0.05 degrees in the last solution.
  bool is_at_rest() const { return editor_->is_at_rest(); }
  /// The converged shape: all vertices, including attached nodes. `report` receives statistics.
  /// Throws InputError, ConflictError, NoSolutionError; the shape is then unchanged.
  const Points& solve_to_equilibrium(DeformReport::Edit& report);

  /// The shape of the last solve_preview() or solve_to_equilibrium().
  const Points& shape() const { return editor_->shape(); }
  /// The problem and the prescribed motion.
  DeformTask task() const { return {editor_->problem(), editor_->edit()}; }
  /// Sentences about parts of the mesh that nothing moves or fixes.
  std::vector<std::string> notes() const { return editor_->notes(); }

 private:
  template <class Function>
  void with_edit_context(const Function& f) const;

  const DeformScene& scene_;
  EditSpec rule_;
  const SharedConstraints& shared_;
  std::unique_ptr<MeshEditor> editor_;
};

}  // namespace batten
