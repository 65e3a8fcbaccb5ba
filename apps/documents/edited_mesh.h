// SPDX-License-Identifier: MPL-2.0
// Document contents of a deform scene: a mesh with its edits.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "batten/apps/documents/document_content.h"
#include "batten/scenes/meshes/edit_session.h"

namespace batten {

/// A mesh file with the edits of a deform scene, applied in order. The text is a scene of `batten
/// deform`, and the converged shape equals its output. Edits that do not yet fix or move anything
/// are skipped. A change of the text recomputes:
///
///     values of the last edit's handles   nothing: two pairs of triangular solves per drag event
///     values of an earlier edit           the edits after it
///     selections, features, edits         these, and all factorizations
///     the mesh                            everything
class EditedMesh : public DocumentContent {
 public:
  EditedMesh();
  ~EditedMesh() override;
  void rebuild(const SceneText& text, const std::filesystem::path& file,
               const Progress& progress) override;
  void update_text(const SceneText& text, const std::filesystem::path& file) override;
  bool moves(const std::string& parameter) const override;
  void check(const std::string& parameter, double value) const override;
  void set(const std::string& parameter, double value) override;
  double value(const std::string& parameter) const override;
  bool solve_preview() override;
  void solve_to_equilibrium() override;
  bool draw(Frame& frame) override;
  void fill_view(DocumentView& view) const override;
  std::string rows() const override;
  std::string run(const std::filesystem::path& folder, const Progress& progress) override;
  std::string export_shape(const std::filesystem::path& file, const Progress& progress) override;

  /// The current shape, all vertices.
  const Points& shape() const;
  /// The mesh as it was read.
  const MeshSource& source() const;

 private:
  struct State;
  void make(const DeformScene& scene, const std::string& topology_text, bool may_fail,
            const Progress& progress);
  void solve(const DeformScene& scene);
  template <class Function>
  void apply_numbers(const Function& go);

  DeformScene scene_;
  std::string topology_text_;  // the scene without handle values and output files
  std::unique_ptr<State> made_;
};

}  // namespace batten
