#include "batten/scenes/shapes/shape_derivatives.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include "batten/analysis/models/shell_sensitivities.h"
#include "batten/core/errors.h"
#include "batten/scenes/shapes/make_session.h"

namespace batten {
namespace {

// The scene with a changed parameter; empty if the value is not permitted.
std::optional<Scene> moved(const Scene& scene, const Parameter& p, double by) {
  try {
    Scene other = scene;
    other.set(p.name, p.value + by, "");
    return other;
  } catch (const InputError&) {
    return std::nullopt;
  }
}

/// Shapes of a scene for other values of one parameter at a time.
class ShapesOfScene {
 public:
  ShapesOfScene(const Scene& scene, const BuiltModel& made, const SolvedShape& shape,
                const Progress& progress)
      : scene_(scene), made_(made), shape_(shape), quiet_{{}, progress.cancelled} {}

  /// Dofs after a parameter has changed; empty if the value is not permitted.
  std::optional<Points> dofs(const Parameter& p, double change) {
    const auto other = moved(scene_, p, change);
    if (!other) return std::nullopt;
    if (!in_session(p)) return solve_shape(*shape_.layout, *other, made_, quiet_).dofs;
    if (!session_)
      session_.emplace(make_session(*shape_.layout, scene_, made_, FactorReuse::many, quiet_));
    session_->set(p.name, p.value + change);
    session_->solve_to_equilibrium();
    return session_->dofs();
  }

  /// Restores a parameter before another one is changed.
  void restore(const Parameter& p) {
    if (in_session(p) && session_) session_->set(p.name, p.value);
  }

 private:
  // True if one session gives the shapes for all values: for the value of a load. All other
  // parameters change the stiffness or the surface on which the scene locates its loads.
  bool in_session(const Parameter& p) const {
    const auto is_parameter = [&](const SceneLoad& load) { return load.name == p.name; };
    const auto drives = [&](const SceneRule& rule) { return rule.of == p.name; };
    return std::any_of(scene_.loads.begin(), scene_.loads.end(), is_parameter) &&
           std::none_of(scene_.rules.begin(), scene_.rules.end(), drives) &&
           !requests_fair_shape(scene_, made_);
  }

  const Scene& scene_;
  const BuiltModel& made_;
  const SolvedShape& shape_;
  Progress quiet_;
  std::optional<SculptingSession> session_;
};

/// The change of a parameter that changes the shape by about 1e-4 of its size; 0: none does; empty:
/// the parameter may not be changed.
///
/// The solver is accurate to about 1e-11 of the size, and the error of a central difference is
/// proportional to the square of the change: both errors are then about 1e-7.
std::optional<double> step_of(const Parameter& p, const SolvedShape& shape, ShapesOfScene& shapes) {
  constexpr double first = 1e-3, target = 1e-4, accepted = 10, no_effect = 1e-10, retry = 1e4;
  const double range = p.max - p.min, size = shape.layout->size();
  const bool bounded = std::isfinite(range) && range > 0;
  double step = first * (bounded ? range : std::max(std::abs(p.value), 1.0));
  for (int attempt = 0; attempt < 2; ++attempt) {
    const double before = step;
    auto at = shapes.dofs(p, step);
    if (!at) at = shapes.dofs(p, -step);
    if (!at) return std::nullopt;
    const double change = (*at - shape.dofs).cwiseAbs().maxCoeff() / size;
    const double factor = change > no_effect ? target / change : retry;
    if (change > no_effect && factor < accepted && factor > 1 / accepted) return step;
    step *= factor;
    constexpr double most = 0.25;  // of the range, so that one side is permitted
    if (bounded) step = std::min(step, most * range);
    if (change > no_effect || step == before) return step;
  }
  return 0;
}

}  // namespace

std::vector<ShapeDerivative> shape_derivatives(const Scene& scene, const BuiltModel& made,
                                               const SolvedShape& shape, const Progress& progress) {
  std::set<std::string> of_lines;
  for_each_fair_parameter(scene.fairing,
                          [&](const std::string& name, double) { of_lines.insert(name); });
  ShapesOfScene shapes(scene, made, shape, progress);
  std::vector<ShapeDerivative> derivatives;
  for (const Parameter& p : scene.parameters()) {
    if (of_lines.count(p.name)) continue;
    progress.update("derivative with respect to " + p.name, 0);
    const auto step = step_of(p, shape, shapes);
    if (!step) continue;
    std::optional<Points> rate(Points::Zero(shape.dofs.rows(), 3));
    if (*step > 0)
      rate = shape_derivative([&](double change) { return shapes.dofs(p, change); }, *step);
    shapes.restore(p);
    if (rate) derivatives.push_back({p.name, std::move(*rate)});
  }
  return derivatives;
}

}  // namespace batten
