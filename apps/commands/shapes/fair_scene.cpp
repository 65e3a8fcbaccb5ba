#include "batten/apps/commands/shapes/fair_scene.h"

#include <algorithm>

#include "batten/apps/commands/shapes/scene_target.h"
#include "batten/core/errors.h"
#include "batten/sculpting/statics/static_sculpt.h"
#include "batten/skinning/model/loft_shape.h"
#include "batten/skinning/surfaces/skin_network.h"

namespace batten {
namespace {

std::vector<std::string> section_names(const Scene& scene) {
  std::vector<std::string> names;
  for (const PlacedWord& section : scene.skin.sections) names.push_back(section.text);
  return names;
}

FairShape lofted(const Scene& scene, const MadeModel& made,
                 std::shared_ptr<const ModelLayout> layout) {
  const std::vector<std::string> sections =
      made.sections.empty() ? section_names(scene) : made.sections;
  FairShape shape;
  shape.fairing = std::make_shared<ShapeFairing>();
  shape.fairing->lofted = true;
  try {
    const double most = 2 * layout->tolerance();
    LoftedModel loft = loft_model(std::move(layout), sections, most);
    shape.layout = std::move(loft.layout);
    shape.dofs = std::move(loft.dofs);
  } catch (const InputError& e) {
    if (scene.skin.sections.empty()) throw;
    throw InputError(scene.at(scene.skin.sections.front().place) + e.what());
  }
  shape.rest = [sections](const RestTask& task) { return loft_shape(task.layout, sections); };
  return shape;
}

/// The first rest shape of a session is the fitted one; under other rows, what bends least from it.
FairShape fitted(const Scene& scene, std::shared_ptr<const ModelLayout> layout, const Points& bent,
                 const Progress& progress) {
  FairShape shape;
  shape.fairing = std::make_shared<ShapeFairing>();
  const double size = layout->size();
  ModelFitOptions options;
  options.tolerance = target_tolerance(scene, size);
  const TargetParts target = target_of(scene, size, progress);
  options.parts = target.parts;
  ModelFit fit = fit_model(std::move(layout), bent, *target.whole, options, progress);
  shape.layout = fit.layout;
  shape.dofs = fit.dofs;
  shape.rest = [first = fit.dofs](const RestTask& task) -> Points {
    return task.near.rows() > 0 || task.bent.rows() != first.rows() ? task.near : first;
  };
  shape.fairing->fit = std::move(fit);
  return shape;
}

VariationOptions variation_options(const Scene& scene) {
  VariationOptions options;
  options.strength = scene.skin.strength;
  if (scene.skin.largest_move > 0) options.largest_move = scene.skin.largest_move;
  return options;
}

/// Rest shapes of a session: the first is known.
class FairRest {
 public:
  FairRest(Points first, VariationOptions options, std::shared_ptr<ShapeFairing> done)
      : first_(std::move(first)), options_(std::move(options)), done_(std::move(done)) {}

  Points operator()(const RestTask& task) {
    const bool first = task.near.rows() == 0 && task.bent.rows() == first_.rows();
    if (first && !std::exchange(begun_, true)) return first_;
    VariationOptions options = options_;
    if (task.near.rows() > 0) options.starts = {task.near};
    options.still.assign(task.layout.mesh()->triangle_count(), 0);
    for (const KeptRegion& kept : done_->kept)
      std::fill_n(options.still.begin() + task.layout.first_triangle(kept.region),
                  task.layout.region(kept.region).mesh()->triangle_count(), 1);
    try {
      done_->surface = fair_shape(task.layout, task.bent, task.rows, options, task.progress);
      done_->not_faired.clear();
      return done_->surface->dofs;
    } catch (const NoSolutionError& e) {
      // What bends least from the last one that could be made is nearer to it than nothing.
      done_->not_faired = e.what();
      return task.near;
    }
  }

 private:
  Points first_;
  VariationOptions options_;
  std::shared_ptr<ShapeFairing> done_;
  bool begun_ = false;
};

FairShape varied(const Scene& scene, const MadeModel& made,
                 std::shared_ptr<const ModelLayout> layout, const Points& bent,
                 const Progress& progress) {
  FairShape shape;
  shape.layout = layout;
  shape.fairing = std::make_shared<ShapeFairing>();
  const double join_tolerance = scene.network.join_tolerance;
  const VariationOptions options = variation_options(scene);
  try {
    FairedModel faired =
        fair_model(made.model, std::move(layout), bent, join_tolerance, options, progress);
    shape.layout = faired.layout;
    shape.dofs = faired.surface.dofs;
    shape.fairing->surface = std::move(faired.surface);
    shape.fairing->kept = std::move(faired.kept);
  } catch (const CancelledError&) {
    throw;
  } catch (const Error& e) {
    shape.fairing->surface.emplace();
    shape.fairing->not_faired = e.what();
    return shape;
  }
  shape.rest = FairRest(shape.dofs, options, shape.fairing);
  return shape;
}

}  // namespace

namespace {

bool is_loft(const Scene& scene, const MadeModel& made) {
  return scene.skin.fair == SceneSkin::Fair::Loft ||
         (scene.skin.fair == SceneSkin::Fair::Auto && !made.sections.empty());
}

}  // namespace

bool asks_for_shape(const Scene& scene, const MadeModel& made) {
  return is_loft(scene, made) || scene.skin.is_faired() || !scene.targets.empty();
}

FairShape fair_scene(const Scene& scene, const MadeModel& made,
                     std::shared_ptr<const ModelLayout> layout, const Points& bent,
                     const Progress& progress) {
  if (!scene.targets.empty()) return fitted(scene, std::move(layout), bent, progress);
  if (is_loft(scene, made)) return lofted(scene, made, std::move(layout));
  return varied(scene, made, std::move(layout), bent, progress);
}

Points bent_shape(const ModelLayout& layout, const Scene& scene, const Progress& progress) {
  StaticTask lines;
  lines.material = scene.skin.material;
  lines.units = scene.skin.units;
  lines.hold_corners = scene.skin.hold == SceneSkin::Hold::Corners;
  return sculpt(layout, lines, progress).dofs;
}

}  // namespace batten
