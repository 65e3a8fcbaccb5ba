// SPDX-License-Identifier: MPL-2.0
#include "batten/apps/documents/edited_shape.h"

#include <algorithm>

#include "batten/core/errors.h"
#include "batten/io/files/text.h"
#include "batten/io/scene/scene.h"
#include "batten/scenes/commands.h"
#include "batten/scenes/lines/scene_lines.h"
#include "batten/scenes/runs/run_support.h"
#include "batten/scenes/shapes/shape_files.h"
#include "batten/scenes/shapes/stress_analysis.h"
#include "batten/scenes/shapes/stress_setup.h"
#include "batten/skinning/model/model_projector.h"

namespace batten {
namespace {

/// Number of models kept for undo.
constexpr size_t kRecentModels = 4;

std::vector<Vec3> points_of(const InputCurve& curve) {
  constexpr int pieces = 96;
  std::vector<Vec3> points;
  for (int i = 0; i <= pieces; ++i)
    points.push_back(curve.evaluate(curve.start() + (curve.end() - curve.start()) * i / pieces));
  return points;
}

/// Unit of a parameter; empty for dimensionless ones, and for loads and stiffness fields.
std::string unit_of(const Scene& scene, const std::string& parameter) {
  const auto is = [&](const auto& thing) { return thing.name == parameter; };
  if (std::any_of(scene.moves.begin(), scene.moves.end(), is)) return scene.unit;
  const size_t dot = parameter.rfind('.');
  if (dot == std::string::npos) return "";
  const std::string owner = parameter.substr(0, dot);
  for (const SceneConstraint& one : scene.constraints)
    if (one.name == owner) return one.type == SceneConstraint::Type::Point ? scene.unit : "";
  return scene.unit;  // stage of [[fair]]
}

}  // namespace

void EditedShape::rebuild(const SceneText& text, const std::filesystem::path& file,
                          const Progress& progress) {
  const Scene scene = parse_scene(text.text(), named_file(file), false);
  const SceneDependencies parts = scene_dependencies(text);
  const bool same_model = model_ && parts.model == parts_.model;
  bool made = false;
  if (session_ && same_model) try {
      made = continue_session(scene, parts);
    } catch (const Error&) {
      rebuild_session(scene_, parts_, true, progress);  // restores the previous state
      throw;
    }
  // Unsatisfiable values of [skin] are rejected, but lines need not form a surface yet.
  if (!made) rebuild_session(scene, parts, !session_ || parts.lines != parts_.lines, progress);
  scene_ = scene;
  parts_ = parts;
  stress_.reset();
  pattern_.reset();  // until drawn again
}

void EditedShape::update_text(const SceneText& text, const std::filesystem::path& file) {
  scene_ = parse_scene(text.text(), named_file(file), false);
  parts_ = scene_dependencies(text);
}

bool EditedShape::continue_session(const Scene& scene, const SceneDependencies& parts) {
  std::vector<std::string> less, more;
  for (const auto& [name, words] : parts_.session_parts) {
    const auto found = parts.session_parts.find(name);
    if (found == parts.session_parts.end() || found->second != words) less.push_back(name);
  }
  for (const auto& [name, words] : parts.session_parts) {
    const auto found = parts_.session_parts.find(name);
    if (found == parts_.session_parts.end() || found->second != words) more.push_back(name);
  }
  // A single change: it succeeds, or the session stays unchanged.
  if (less.size() + more.size() > 1) return false;
  if (!more.empty()) {
    for (const SceneLoad& load : scene.loads)
      if (more.front() == "load " + load.name && load.keyframes.empty() &&
          (load.type == SceneLoad::Type::Point || load.type == SceneLoad::Type::AttractorSprings)) {
        add_load(*session_, scene, model_->model.made, load, start_.constrained);
        apply_values(scene);
        return true;
      }
    return false;
  }
  if (!less.empty()) {
    const size_t blank = less.front().find(' ');
    const std::string kind = less.front().substr(0, blank);
    if (kind != "load" && kind != "stiffness") return false;
    session_->remove(less.front().substr(blank + 1));
  }
  apply_values(scene);
  return true;
}

void EditedShape::apply_values(const Scene& scene) {
  for (const ScalarParameter& p : scene.named_values()) {
    if (!p.rule_terms.empty() || !p.keyframes.empty() || !session_->parameters().has(p.name))
      continue;
    if (session_->parameters().value(p.name) != p.value) session_->set(p.name, p.value);
  }
  solve_report_ = session_->solve_to_equilibrium();
  session_->clear_history();  // a document restores texts
}

std::shared_ptr<const DocumentModel> EditedShape::model_for(const Scene& scene,
                                                            const std::string& of,
                                                            const Progress& progress) {
  for (auto it = recent_models_.begin(); it != recent_models_.end(); ++it)
    if ((*it)->of == of) {
      recent_models_.splice(recent_models_.begin(), recent_models_, it);
      lines_ = recent_models_.front()->lines;
      return recent_models_.front();
    }
  progress.update("curves", 0);
  auto made = std::make_shared<DocumentModel>();
  made->of = of;
  made->lines = faired_lines(scene, progress).lines;
  lines_ = made->lines;
  made->model = sculpt_model(build_model(scene, made->lines, progress), scene, progress);
  recent_models_.push_front(made);
  if (recent_models_.size() > kRecentModels) recent_models_.pop_back();
  return made;
}

void EditedShape::rebuild_session(const Scene& scene, const SceneDependencies& parts, bool may_fail,
                                  const Progress& progress) {
  const std::vector<CharacterLine> lines_before = lines_;
  std::shared_ptr<const DocumentModel> model;
  std::unique_ptr<SculptingSession> session;
  SessionReference start;
  SolveReport report;
  std::string problem;
  try {
    lines_.clear();
    if (!scene.lines.empty()) {
      model = model_for(scene, parts.model, progress);
      progress.update("session", 0);
      session = std::make_unique<SculptingSession>(
          make_session(*model->model.layout, scene, model->model.made, FactorReuse::many, progress,
                       &start, model->model.fair.rest));
      report = session->solve_to_equilibrium();
    }
  } catch (const CancelledError&) {
    lines_ = lines_before;
    throw;
  } catch (const Error& e) {
    if (!may_fail) {
      lines_ = lines_before;
      throw;
    }
    problem = e.what();
    session.reset();
  }
  model_ = std::move(model);
  session_ = std::move(session);
  start_ = std::move(start);
  solve_report_ = report;
  problem_ = std::move(problem);
}

bool EditedShape::moves(const std::string& parameter) const {
  return session_ && is_session_parameter(scene_, parameter);
}

void EditedShape::check(const std::string& parameter, double value) const {
  Scene(scene_).set(parameter, value, "");
}

void EditedShape::set(const std::string& parameter, double value) {
  session_->set(parameter, value);
}

double EditedShape::value(const std::string& parameter) const {
  return session_->parameters().value(parameter);
}

bool EditedShape::solve_preview() {
  if (session_) solve_report_ = session_->solve_preview();
  return solve_report_.converged;
}

void EditedShape::solve_to_equilibrium() {
  if (!session_) return;
  if (session_->in_motion()) {
    session_->stop_motion();
    session_->set_time(0);
  }
  solve_report_ = session_->solve_to_equilibrium();
  session_->clear_history();
}

void EditedShape::step(double dt) {
  if (!session_) return DocumentContent::step(dt);
  const SceneMotion& motion = scene_.motion;
  if (!session_->in_motion() || dt != dt_)
    session_->start_motion({dt, motion.density, motion.damping, motion.theta});
  dt_ = dt;
  solve_report_ = session_->step();
}

bool EditedShape::draw(Frame& frame) {
  if (!session_) return false;
  session_->draw(frame);
  if (pattern_ == frame.pattern) return true;
  pattern_ = frame.pattern;
  const Surface constrained = session_->layout().surface(start_.constrained);
  std::vector<float> points;
  for (const Location& where : pattern_->locations)
    for (const double x : Vec3(constrained.position(where)))
      points.push_back(static_cast<float>(x));
  unloaded_ = std::make_shared<const std::vector<float>>(std::move(points));
  return true;
}

std::shared_ptr<const StressView> EditedShape::stress(Analysis what) {
  if (!session_ || !pattern_ || !scene_.stress) return nullptr;
  auto view = std::make_shared<StressView>();
  try {
    if (!stress_) stress_.emplace(shell_problem(scene_));
    const ShellEvaluator::MaxValues largest = stress_->at(session_->layout(), session_->dofs());
    if (what == Analysis::Modes) {
      constexpr int usual = 6;
      const int count = scene_.stress->modes > 0 ? scene_.stress->modes : usual;
      ShellEvaluator::ModeShapes mode_shapes = stress_->mode_shapes(pattern_->locations, count);
      view->frequencies = std::move(mode_shapes.frequencies);
      view->mode_shapes = std::move(mode_shapes.displacements);
      return view;
    }
    ShellEvaluator::Field field = stress_->field(pattern_->locations);
    view->load_case = field.load_case;
    view->von_mises = largest.von_mises;
    view->displacement = largest.displacement;
    view->yield = scene_.stress->yield;
    view->deformation_scale = deformation_scale(largest.displacement, session_->layout().size());
    view->values = std::move(field.von_mises);
    view->moved = std::move(field.displacement);
  } catch (const CancelledError&) {
    throw;
  } catch (const Error& e) {
    stress_.reset();
    view->problem = e.what();
  }
  return view;
}

PickedPoint EditedShape::nearest_point(const Vec3& near) const {
  if (!session_) throw InputError("found no surface, expected a scene with a surface");
  const ModelLayout& layout = session_->layout();
  const ModelProjector present(layout, session_->dofs());
  const ModelProjector::Nearest found = present.nearest_inside(near);
  const Location where = layout.to_model_location(found.at.region, found.where);
  const SurfaceJet jet = layout.surface(session_->dofs()).jet(where);
  return {layout.region(found.at.region).name(), jet.x, jet.normal(),
          layout.surface(start_.constrained).position(where)};
}

void EditedShape::fill_view(DocumentView& view) const {
  view.unit = scene_.unit;
  for (const ScalarParameter& p : scene_.named_values()) {
    const bool driven = !p.rule_terms.empty() || !p.keyframes.empty();
    DocumentView::Slider slider{p.name, unit_of(scene_, p.name), p.value, p.min, p.max, driven};
    if (session_ && session_->parameters().has(p.name))
      slider.value = session_->parameters().value(p.name);
    view.sliders.push_back(slider);
  }
  for (const CharacterLine& line : lines_)
    view.lines.push_back({line.name, points_of(*line.curve)});
  for (const SceneConstraint& pin : scene_.constraints)
    if (session_ && pin.type == SceneConstraint::Type::Point &&
        session_->parameters().has(pin.name + ".x")) {
      DocumentView::Handle handle{pin.name};
      handle.centre = constraint_target(pin);
      handle.shift = handle.centre;
      handle.can_rotate = false;
      handle.moves = true;
      view.handles.push_back(std::move(handle));
    }
  add_marks(view);
  if (!session_) return;
  const SculptingSession& session = *session_;
  const ModelLayout& layout = session.layout();
  view.surface = true;
  if (pattern_) view.unloaded = unloaded_;
  view.triangles = layout.mesh()->triangle_count();
  view.size = layout.size();
  view.has_stress = scene_.stress.has_value();
  for (const SkinnedRegion& region : session.regions()) {
    view.regions.push_back(region.name);
    for (const EdgeAlignedLine& aligned_line : region.edge_aligned)
      view.shown_lines.push_back(aligned_line.line.name);
    for (const EmbeddedLine& line : region.embedded) view.shown_lines.push_back(line.line.name);
  }
  const SculptModel& model = model_->model;
  const BuiltModel& made = model.made;
  if (made.network)
    view.network = network_report(*made.network, *made.found, made.model, made.fit_tolerance,
                                  scene_.network.join_tolerance);
  view.defects = defect_reports(made.model);
}

// Current position or direction that a constraint prescribes.
Vec3 EditedShape::constraint_target(const SceneConstraint& one) const {
  Vec3 goal = one.goal;
  for (int i = 0; i < 3; ++i)
    if (const std::string name = one.name + "." + "xyz"[i];
        session_ && session_->parameters().has(name))
      goal[i] = session_->parameters().value(name);
  return goal;
}

// Marks of loads, forces, normal constraints and supports.
void EditedShape::add_marks(DocumentView& view) const {
  using Mark = DocumentView::Mark;
  for (const SceneLoad& load : scene_.loads)
    if (load.type == SceneLoad::Type::Point)
      view.marks.push_back({Mark::Kind::Load, load.at, load.direction});
  for (const SceneConstraint& one : scene_.constraints)
    if (one.type == SceneConstraint::Type::Normal)
      view.marks.push_back({Mark::Kind::Normal, one.at, constraint_target(one)});
  if (!scene_.stress) return;
  for (const SceneStress::Load& load : scene_.stress->loads)
    if (load.type == SceneStress::Load::Type::Point)
      view.marks.push_back({Mark::Kind::Force, load.point, load.vector});
  for (const SceneStress::Support& support : scene_.stress->supports) {
    if (!support.line.text.empty()) view.supported_lines.push_back(support.line.text);
    if (support.point) view.marks.push_back({Mark::Kind::Support, *support.point, Vec3::Zero()});
  }
}

std::string EditedShape::rows() const {
  if (!session_)
    return summary_line("surface", "none: " + (problem_.empty() ? "no curves" : problem_));
  const ModelLayout& layout = session_->layout();
  std::string text = summary_line(
      "surface", format_count(layout.region_count(), "face") + ", " +
                     format_count(layout.mesh()->triangle_count(), "element") + ", energy " +
                     format_number(session_->energy().stretching + session_->energy().bending));
  for (const ScalarParameter& p : session_->parameters().all())
    text += summary_line("", p.name + " = " + format_number(session_->parameters().value(p.name)));
  return text;
}

// Output of a shape.

std::string EditedShape::run(const std::filesystem::path& folder, const Progress& progress) {
  return sentence_lines(run_scene(scene_, folder, progress).failed_checks);
}

std::string EditedShape::export_shape(const std::filesystem::path& file, const Progress& progress) {
  if (!session_) throw InputError("found no surface to export, expected a scene with a surface");
  const SolvedShape shape = shape_of(*session_, scene_, start_.unloaded, solve_report_);
  return sentence_lines(
      batten::export_shape(scene_, model_->model.made, shape, file, progress).failed_checks);
}

}  // namespace batten
