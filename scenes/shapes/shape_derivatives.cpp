// SPDX-License-Identifier: MPL-2.0
#include "batten/scenes/shapes/shape_derivatives.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <optional>
#include <set>
#include <utility>

#include "batten/core/errors.h"
#include "batten/scenes/shapes/make_session.h"

namespace batten {
namespace {

bool is_stiffness(const Parameter& p) {
  return p.name.starts_with("alpha") || p.name.starts_with("beta");
}

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

/// Shapes of a scene for other values of one parameter at a time, on the elements of a shape.
class ShapesOfScene {
 public:
  ShapesOfScene(const Scene& scene, const BuiltModel& made, const SolvedShape& shape,
                const Progress& progress)
      : scene_(scene), made_(made), shape_(shape), quiet_{{}, progress.cancelled} {}

  /// Dofs after a parameter has changed; empty if the value is not permitted, or has no solution.
  std::optional<Points> dofs(const Parameter& p, double change) {
    const auto other = moved(scene_, p, change);
    if (!other) return std::nullopt;
    try {
      return in_session(p) ? session_dofs(p, p.value + change) : scene_dofs(*other, p);
    } catch (const NoSolutionError&) {
      return std::nullopt;
    }
  }

  /// Restores a parameter before another one is changed.
  void restore(const Parameter& p) {
    if (in_session(p) && session_) session_->set(p.name, p.value);
  }

 private:
  Points session_dofs(const Parameter& p, double value) {
    if (!session_)
      session_.emplace(make_session(*shape_.layout, scene_, made_, FactorReuse::many, quiet_));
    session_->set(p.name, value);
    session_->solve_to_equilibrium();
    return session_->dofs();
  }

  Points scene_dofs(const Scene& scene, const Parameter& p) const {
    SolvedShape solved = solve_shape(*shape_.layout, scene, made_, quiet_);
    const ParametricMesh &mesh = *solved.layout->mesh(), &own = *shape_.layout->mesh();
    if (mesh.vertices() != own.vertices() || mesh.triangles() != own.triangles())
      throw InputError(scene_.name +
                       ": found a fitted or lofted shape whose elements change with '" + p.name +
                       "', expected a shape on fixed elements, which has derivatives");
    return std::move(solved.dofs);
  }

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

/// Derivative of the shape with respect to one parameter, from differences.
class Differences {
 public:
  Differences(const Parameter& p, const SolvedShape& shape, ShapesOfScene& shapes)
      : p_(p), size_(shape.layout->size()), shapes_(shapes) {}

  /// Empty if the parameter may not be changed. `here`: the shape for its own value.
  std::optional<Points> derivative(const Points& here) {
    here_ = &here;
    const auto step = first_step();
    if (!step) return std::nullopt;
    constexpr double no_effect = 1e-11;
    if (change_by(*step) <= no_effect) return Points(Points::Zero(here.rows(), 3));
    return extrapolated(*step);
  }

 private:
  /// Shape after a change, from the last ones that were computed.
  const std::optional<Points>& at(double change) {
    for (const auto& [of, dofs] : known_)
      if (of == change) return dofs;
    known_.emplace_back(change, shapes_.dofs(p_, change));
    return known_.back().second;
  }

  double change_by(double step) {
    for (const double s : {step, -step})
      if (const auto& dofs = at(s)) return (*dofs - *here_).cwiseAbs().maxCoeff() / size_;
    return std::numeric_limits<double>::infinity();
  }

  // The largest step to try: nonlinear effects of a stiffness begin at a fraction of its value.
  double largest_step() const {
    constexpr double of_stiffness = 0.02, of_range = 0.1;
    const double range = p_.max - p_.min;
    if (is_stiffness(p_)) return of_stiffness * (p_.value > 0 ? p_.value : 1);
    return std::isfinite(range) && range > 0 ? of_range * range
                                             : std::numeric_limits<double>::infinity();
  }

  /// A step that changes the shape by about 1e-4 of its size, or the largest step if its effect is
  /// smaller. Starts with a tiny step, because larger ones may have no solution.
  std::optional<double> first_step() {
    constexpr double tiny = 1e-5, target = 1e-4, enough = 3e-5, most_growth = 1e4, noise = 1e-10;
    constexpr int attempts = 8;
    const double largest = largest_step(), range = p_.max - p_.min;
    double step = tiny * (p_.value != 0                       ? std::abs(p_.value)
                          : std::isfinite(range) && range > 0 ? range
                                                              : 1);
    step = std::min(step, largest);
    for (int attempt = 0; attempt < attempts; ++attempt) {
      const double change = change_by(step);
      if (!std::isfinite(change)) {
        constexpr double back = 1e-3;
        if (attempt + 1 == attempts) return std::nullopt;
        step *= back;
        continue;
      }
      if (change >= enough || step >= largest) break;
      const double growth = change > noise ? std::min(target / change, most_growth) : most_growth;
      step = std::min(step * growth, largest);
    }
    return std::isfinite(change_by(step)) ? std::optional(step) : std::nullopt;
  }

  /// Second-order difference: a central one, or a one-sided one if only one side has a shape.
  std::optional<Points> difference(double step) {
    const auto& up = at(step);
    const auto& down = at(-step);
    if (up && down) return Points((*up - *down) / (2 * step));
    const double side = up ? step : -step;
    const auto& near = at(side);
    const auto& far = at(2 * side);
    if (!near || !far) return std::nullopt;
    return Points((4 * *near - *far - 3 * *here_) / (2 * side));
  }

  /// Richardson extrapolation of differences of second order. The step is reduced while they
  /// disagree.
  std::optional<Points> extrapolated(double step) {
    constexpr double agree = 1e-3, reduction = 8;
    constexpr int attempts = 4;
    std::optional<Points> best;
    double least = std::numeric_limits<double>::infinity();
    for (int attempt = 0; attempt < attempts; ++attempt, step /= reduction) {
      const auto coarse = difference(step), fine = difference(step / 2);
      if (!coarse || !fine) continue;
      const double largest = fine->cwiseAbs().maxCoeff(),
                   error = (*fine - *coarse).cwiseAbs().maxCoeff() / std::max(largest, 1e-300);
      if (error < least) {
        least = error;
        best = Points((4 * *fine - *coarse) / 3);
      }
      if (error < agree) break;
    }
    return best;
  }

  const Parameter& p_;
  double size_;
  ShapesOfScene& shapes_;
  const Points* here_ = nullptr;
  std::deque<std::pair<double, std::optional<Points>>> known_;
};

}  // namespace

std::vector<ShapeDerivative> shape_derivatives(const Scene& scene, const BuiltModel& made,
                                               const SolvedShape& shape, const Progress& progress) {
  std::set<std::string> of_lines;
  for_each_fair_parameter(scene.fairing,
                          [&](const std::string& name, double) { of_lines.insert(name); });
  ShapesOfScene shapes(scene, made, shape, progress);
  std::vector<ShapeDerivative> derivatives;
  for (const Parameter& p : scene.parameters()) {
    if (of_lines.count(p.name) || !moved(scene, p, 0)) continue;
    progress.update("derivative with respect to " + p.name, 0);
    const auto here = shapes.dofs(p, 0);
    constexpr double equilibrium = 1e-5;
    if (!here ||
        !((*here - shape.dofs).cwiseAbs().maxCoeff() <= equilibrium * shape.layout->size()))
      throw InputError(scene.name + (requests_fair_shape(scene, made)
                                         ? ": found a fitted, lofted or faired shape that depends "
                                           "on its refinement, expected "
                                           "one of minimum bending energy, which has derivatives"
                                         : ": found a shape that is not in equilibrium, which has "
                                           "no derivatives; solve() the "
                                           "session first, and end its motion"));
    auto rate = Differences(p, shape, shapes).derivative(*here);
    shapes.restore(p);
    if (rate) derivatives.push_back({p.name, std::move(*rate)});
  }
  return derivatives;
}

}  // namespace batten
