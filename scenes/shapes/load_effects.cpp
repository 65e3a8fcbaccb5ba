// SPDX-License-Identifier: MPL-2.0
#include "batten/scenes/shapes/load_effects.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/io/files/text.h"
#include "batten/scenes/shapes/make_session.h"

namespace batten {
namespace {

constexpr double kVisible = 0.01;  // displacement that is visible, relative to the size

/// Names of the parameters whose effect is a displacement, except driven ones.
std::vector<std::string> moving_parameters(const Scene& scene) {
  std::vector<std::string> names;
  const auto add = [&](const ScalarParameter& p) {
    const bool driven = std::any_of(scene.rules.begin(), scene.rules.end(),
                                    [&](const SceneRule& rule) { return rule.driven == p.name; });
    if (!driven && p.max > p.min && p.keyframes.empty()) names.push_back(p.name);
  };
  for (const SceneLoad& load : scene.loads) add(load);
  for (const SceneLineOffset& offset : scene.moves) add(offset);
  for (const ScalarParameter& slider : scene.sliders) add(slider);
  return names;
}

/// The largest displacement of a vertex between two shapes, and where it is.
struct Displacement {
  double length = 0;
  Vec3 at = Vec3::Zero();
};

Displacement displacement(const ParametricMesh& mesh, const Points& from, const Points& to) {
  const DofMap dofs(mesh);
  Displacement largest;
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    const Vec3 before = from.row(dofs.vertex(v)), after = to.row(dofs.vertex(v));
    if ((after - before).norm() > largest.length) largest = {(after - before).norm(), before};
  }
  return largest;
}

/// The face with the vertex nearest to a point.
std::string face_at(const std::vector<SkinnedRegion>& faces, const Vec3& at) {
  std::string name;
  double nearest = kInfinity;
  for (const SkinnedRegion& face : faces)
    for (int v = 0; v < face.surface.mesh().vertex_count(); ++v) {
      const Vec3 p = face.surface.dofs().row(face.surface.dof_map().vertex(v));
      if ((p - at).norm() < nearest) {
        nearest = (p - at).norm();
        name = face.name;
      }
    }
  return name;
}

/// Changes one parameter of a session at a time, and measures the displacements.
class Probe {
 public:
  Probe(SculptingSession session, const SolvedShape& shape)
      : session_(std::move(session)), shape_(shape) {
    session_.solve_to_equilibrium();
    rest_ = session_.dofs();
  }

  /// The effect of a parameter; empty if it may not be changed, or if there is no solution.
  std::optional<LoadEffect> effect(const Parameter& p) {
    constexpr double target = 1e-4, least = 1e-7, most = 2e-2;  // relative to the size
    const double size = shape_.layout->size();
    double step = first_step(p);
    std::optional<Displacement> moved = displaced(p, step);
    for (int attempt = 0; !moved && attempt < 4; ++attempt) moved = displaced(p, step *= 1e-3);
    if (moved && moved->length > 0 &&
        (moved->length < least * size || moved->length > most * size)) {
      step *= target * size / moved->length;
      if (const double bounded = within(p, step); displaced(p, bounded))
        moved = displaced(p, step = bounded);
    }
    if (!moved) return std::nullopt;
    const double per_unit = moved->length / std::abs(step);
    return LoadEffect{p.name, per_unit, moved->at, face_at(shape_.regions, moved->at),
                      per_unit > 0 ? kVisible * size / per_unit : 0};
  }

 private:
  // The largest step of this size that stays in the range of the parameter.
  static double within(const Parameter& p, double step) {
    if (p.value + step <= p.max) return step;
    return p.value - step >= p.min ? -step
                                   : (p.max - p.value > p.value - p.min ? p.max : p.min) - p.value;
  }
  static double first_step(const Parameter& p) {
    constexpr double of_value = 1e-2;
    return within(p, p.value != 0 ? of_value * std::abs(p.value) : 1);
  }

  std::optional<Displacement> displaced(const Parameter& p, double step) {
    std::optional<Displacement> result;
    try {
      session_.set(p.name, p.value + step);
      session_.solve_to_equilibrium();
      result = displacement(*shape_.layout->mesh(), rest_, session_.dofs());
    } catch (const InputError&) {  // out of range, or a conflict
    } catch (const NoSolutionError&) {
    }
    session_.set(p.name, p.value);
    return result;
  }

  SculptingSession session_;
  const SolvedShape& shape_;
  Points rest_;
};

}  // namespace

std::vector<LoadEffect> load_effects(const Scene& scene, const BuiltModel& made,
                                     const SolvedShape& shape, const Progress& progress) {
  const std::vector<std::string> names = moving_parameters(scene);
  if (names.empty() || !shape.layout) return {};
  const Progress quiet{{}, progress.cancelled};
  Probe probe(make_session(*shape.layout, scene, made, FactorReuse::many, quiet), shape);
  std::vector<LoadEffect> effects;
  for (const Parameter& p : scene.parameters()) {
    if (std::find(names.begin(), names.end(), p.name) == names.end()) continue;
    progress.update("effect of " + p.name, 0);
    if (const auto effect = probe.effect(p)) effects.push_back(*effect);
  }
  return effects;
}

namespace {

/// A number with three digits, which is enough for a linear estimate.
std::string estimate(double value) {
  if (value == 0) return "0";
  const double digit = std::pow(10, std::floor(std::log10(std::abs(value))) - 2);
  return format_number(std::round(value / digit) * digit);
}

/// A point, rounded to a thousandth of the size.
std::string approximate_point(const Vec3& p, double size) {
  const double digit = std::pow(10, std::floor(std::log10(size)) - 3);
  return format_point((p / digit).array().round() * digit);
}

}  // namespace

std::string effects_text(const std::vector<LoadEffect>& effects, const std::string& unit) {
  std::string text = effects.empty() ? "" : "effects of small changes\n";
  for (const LoadEffect& effect : effects) {
    const double size = effect.displacement * effect.visible / kVisible;
    text += "  " + printable(effect.parameter) + ": ";
    text += effect.displacement > 0
                ? "1 displaces the surface by up to " + estimate(effect.displacement) + " " + unit +
                      ", at " + approximate_point(effect.at, size) + " on face '" +
                      printable(effect.face) + "'; " + estimate(effect.visible) +
                      " displaces it by about 1 % of its size"
                : "does not displace the surface";
    text += "\n";
  }
  return text;
}

void check_load_sizes(Report& report, const Scene& scene) {
  constexpr double least = 1e-6, most = 10;  // relative to the size
  const double moved = report.surface.moved, size = report.surface.size;
  std::string names;
  double value = 0;
  int count = 0;
  for (const Parameter& p : scene.parameters())
    for (const SceneLoad& load : scene.loads)
      if (load.name == p.name && p.value != 0) {
        names += (names.empty() ? "'" : ", '") + p.name + "' = " + format_number(p.value);
        value = p.value;
        ++count;
      }
  if (count == 0 || (moved >= least * size && moved <= most * size)) return;
  const double factor = moved > 0 ? kVisible * size / moved : 0;
  std::string advice = "check its place and direction";
  if (factor > 0 && count == 1)
    advice = "a value near " + estimate(factor * value) + " displaces it by about 1 %";
  else if (factor > 0)
    advice = "values " +
             (factor > 1 ? estimate(factor) + " times as large"
                         : estimate(1 / factor) + " times smaller") +
             " displace it by about 1 %";
  report.warnings.push_back("the load " + names + " displaces the surface by " + estimate(moved) +
                            " " + report.unit + ", " + estimate(moved / size) + " of its size; " +
                            advice);
}

}  // namespace batten
