// SPDX-License-Identifier: MPL-2.0
#include "batten/scenes/meshes/morph_solver.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "batten/core/containers.h"
#include "batten/scenes/meshes/morph_targets.h"

namespace batten {
namespace {

void append_vector(std::vector<double>& values, const Vec3& v) {
  values.insert(values.end(), v.begin(), v.end());
}

/// The values of an edit that are parameters.
std::vector<double> edit_values(const EditSpec& edit) {
  std::vector<double> values;
  for (const auto& h : edit.handles) {
    append_vector(values, h.translate);
    append_vector(values, h.axis);
    values.push_back(h.degrees);
    values.push_back(h.scale);
  }
  for (const auto& s : edit.scales) values.push_back(s.factor);
  for (const auto& g : edit.guides) append_vector(values, g.through);
  return values;
}

/// The values of the constraints that all edits share.
std::vector<double> shared_values(const DeformScene& scene) {
  std::vector<double> values;
  for (const GuideSpec& guide : scene.guides)
    if (guide.through) append_vector(values, *guide.through);
  for (const PositionConstraintSpec& constraint : scene.position_constraints)
    append_vector(values, constraint.to);
  for (const CurveSpec& curve : scene.curves)
    for (const CurveLoad& load : curve.loads) values.push_back(load.value);
  return values;
}

}  // namespace

/// What a failed solution restores.
struct MorphSolver::Backup {
  DeformScene scene;
  SharedConstraints shared;
  bool solved;    // all edits have solutions
  size_t first;   // the first changed edit
  EditSpec rule;  // this edit
  /// The edits after the first changed one, which start from its former shape.
  std::vector<std::unique_ptr<EditSession>> behind;
};

MorphSolver::MorphSolver(DeformScene scene, const MeshSource& source, double tolerance)
    : scene_(std::move(scene)),
      source_(source),
      tolerance_(tolerance),
      select_(scene_, source.file, source.prepared.mesh),
      attached_(source.file.other_elements(), source.prepared.mesh, scene_.following,
                source.file.ties(), source.prepared.face_of_triangle) {}

std::vector<Points> MorphSolver::states() const {
  std::vector<Points> states{mesh().points()};
  for (const auto& edit : edits_) states.push_back(edit->shape());
  return states;
}

size_t MorphSolver::first_changed_edit(const DeformScene& values) const {
  if (!gathered_ || shared_values(values) != shared_values(scene_)) return 0;
  size_t first = 0;
  while (first < edits_.size() &&
         edit_values(values.edits[first]) == edit_values(edits_[first]->rule()))
    ++first;
  return first;
}

const Points& MorphSolver::solve(const DeformScene& values, const Progress& progress) {
  const size_t first = first_changed_edit(values);
  if (first == values.edits.size() && gathered_) {
    scene_ = values;
    return shape();
  }
  Backup backup{scene_, shared_, gathered_ && edits_.size() == scene_.edits.size(), first, {}, {}};
  if (first < edits_.size()) {
    backup.rule = edits_[first]->rule();
    std::move(edits_.begin() + static_cast<long>(first) + 1, edits_.end(),
              std::back_inserter(backup.behind));
    edits_.resize(first + 1);
  }
  try {
    solve_from(first, values, progress);
  } catch (...) {
    restore(backup);
    throw;
  }
  return shape();
}

void MorphSolver::solve_from(size_t first, const DeformScene& values, const Progress& progress) {
  if (!gathered_ || shared_values(values) != shared_values(scene_)) {
    progress.update("features", 0);
    SharedConstraints shared = gather_shared_constraints(values, select_, attached_, mesh());
    if (gathered_) {
      shared.targets = shared_.targets;
      shared.surfaces = shared_.surfaces;
    } else {
      gather_targets(values, select_, mesh(), shared);
    }
    shared_ = std::move(shared);
  }
  gathered_ = true;
  scene_ = values;
  for (size_t k = first; k < scene_.edits.size(); ++k) {
    const EditSpec& rule = scene_.edits[k];
    progress.update(rule.name, static_cast<double>(k) / static_cast<double>(scene_.edits.size()));
    if (k < edits_.size()) {
      edits_[k]->set(rule);
      edits_[k]->solve_to_equilibrium();
      continue;
    }
    auto edit = std::make_unique<EditSession>(scene_, rule, shared_, select_, source_.prepared,
                                              shape(), tolerance_);
    edit->solve_to_equilibrium();
    edits_.push_back(std::move(edit));
  }
}

void MorphSolver::restore(Backup& backup) {
  if (!backup.solved) {  // features and constraints remain for display
    edits_.clear();
    return;
  }
  scene_ = std::move(backup.scene);
  shared_ = std::move(backup.shared);
  edits_.resize(backup.first + 1);
  edits_.back()->set(backup.rule);
  edits_.back()->solve_to_equilibrium();
  std::move(backup.behind.begin(), backup.behind.end(), std::back_inserter(edits_));
}

}  // namespace batten
