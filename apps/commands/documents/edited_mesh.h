// A mesh that is edited.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "batten/apps/commands/documents/document_content.h"
#include "batten/apps/commands/documents/mesh_display.h"
#include "batten/apps/commands/meshes/edit_session.h"
#include "batten/apps/commands/meshes/mesh_source.h"

namespace batten {

/// A mesh file, what a deform scene says of it, and its edits one after the other. The text is that of
/// `batten deform`, and the shape at rest is what that would write; an edit that neither holds nor
/// moves anything yet is passed over. A change of the text makes anew
///
///     numbers of the last edit's handles   nothing: two pairs of triangular solves in a drag
///     numbers of an edit before            the edits behind it
///     selections, features, edits          these, and all factors
///     the mesh                             all
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

  /// The shape that is there, all vertices; and the mesh as it was read.
  const Points& shape() const;
  const MeshSource& source() const;

 private:
  struct State;
  void make(const DeformScene& scene, const std::string& topology_text, bool may_fail,
            const Progress& progress);
  void set_numbers(const DeformScene& scene);
  template <class Function>
  void apply_numbers(const Function& go);

  DeformScene scene_;
  std::string topology_text_;  // of the scene, without numbers of handles and what files are made
  std::unique_ptr<State> made_;
};

}  // namespace batten
