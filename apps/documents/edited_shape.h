// SPDX-License-Identifier: MPL-2.0
// Document contents of a surface scene: curves, their surface and a sculpting session.
#pragma once

#include <list>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "batten/analysis/models/shell_evaluator.h"
#include "batten/apps/documents/document_content.h"
#include "batten/io/scene/scene_text.h"
#include "batten/scenes/shapes/make_session.h"
#include "batten/scenes/shapes/solved_shape.h"

namespace batten {

/// The model of a scene's lines, without loads and constraints.
struct DocumentModel {
  std::string of;  ///< key: SceneDependencies::model
  std::vector<CharacterLine> lines;
  SculptModel model;
};

/// Curves, their surface and a session on it. A change of the text recomputes:
///
///     a value                         nothing: the session continues, with a few pairs of
///                                     triangular solves
///     a point load or attractor       nothing: the session continues
///       added, a load or stiffness
///       field removed
///     other loads, constraints, …     the session, on the same model
///     curves, joins, [skin], [mesh]   the model; recent models are cached
class EditedShape : public DocumentContent {
 public:
  void rebuild(const SceneText& text, const std::filesystem::path& file,
               const Progress& progress) override;
  void update_text(const SceneText& text, const std::filesystem::path& file) override;
  bool moves(const std::string& parameter) const override;
  void check(const std::string& parameter, double value) const override;
  void set(const std::string& parameter, double value) override;
  double value(const std::string& parameter) const override;
  bool solve_preview() override;
  void solve_to_equilibrium() override;
  void step(double dt) override;
  bool in_motion() const override { return session_ && session_->in_motion(); }
  bool draw(Frame& frame) override;
  PickedPoint nearest_point(const Vec3& near) const override;
  std::shared_ptr<const StressView> stress(Analysis what) override;
  void fill_view(DocumentView& view) const override;
  std::string rows() const override;
  std::string run(const std::filesystem::path& folder, const Progress& progress) override;
  std::string export_shape(const std::filesystem::path& file, const Progress& progress) override;

  /// The lines, after fairing by [[fair]]; those of the current text as far as they can be read.
  const std::vector<CharacterLine>& lines() const { return lines_; }
  /// The sculpting session, or null.
  SculptingSession* session() const { return session_.get(); }

 private:
  void rebuild_session(const Scene& scene, const SceneDependencies& parts, bool may_fail,
                       const Progress& progress);
  bool continue_session(const Scene& scene, const SceneDependencies& parts);
  void apply_values(const Scene& scene);
  void add_marks(DocumentView& view) const;
  Vec3 constraint_target(const SceneConstraint& one) const;
  std::shared_ptr<const DocumentModel> model_for(const Scene& scene, const std::string& of,
                                                 const Progress& progress);

  Scene scene_;
  SceneDependencies parts_;
  std::vector<CharacterLine> lines_;
  std::shared_ptr<const DocumentModel> model_;
  std::unique_ptr<SculptingSession> session_;
  SessionReference start_;
  SolveReport solve_report_;
  double dt_ = 0;                                       // time step of the motion
  std::shared_ptr<const DisplayTopology> pattern_;      // topology that was drawn
  std::shared_ptr<const std::vector<float>> unloaded_;  // its points on the unloaded surface
  std::optional<ShellEvaluator> stress_;
  std::list<std::shared_ptr<const DocumentModel>> recent_models_;
};

}  // namespace batten
