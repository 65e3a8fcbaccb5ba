// SPDX-License-Identifier: MPL-2.0
// [stress] of a scene as a CalculiX deck.
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <functional>
#include <numbers>
#include <utility>

#include "batten/scenes/shapes/stress_places.h"
#include "batten/scenes/shapes/stress_setup.h"

namespace batten {
namespace {

using Support = SceneStress::Support;
using Load = SceneStress::Load;

class DeckOfScene {
 public:
  DeckOfScene(const Scene& scene, const ModelLayout& layout, const std::string& file)
      : scene_(scene), layout_(layout), file_(file) {}

  ShellDeck made(const std::string& load_case) {
    const SceneStress& stress = *scene_.stress;
    add_section();
    // With the OFFSET of a section, ccx applies nodal forces in the middle of the shell all the same.
    if (stress.offset != 0) refuse({}, "a reference surface at the top or bottom");
    deck_.units = "lengths in " + scene_.unit;
    for (const auto& of : stress.thicknesses) {
      if (of.region.text.empty()) refuse({}, "a variable thickness");
      if (!deck_.plies.empty()) refuse({}, "several thicknesses of an orthotropic material");
      find_region(layout_, scene_, of.region);
      deck_.thicknesses.push_back({of.region.text, of.thickness});
    }
    if (!stress.stiffeners.empty()) refuse(stress.stiffeners[0].line.location, "a stiffener");
    if (!stress.rigid_curves.empty()) refuse(stress.rigid_curves[0].location, "a rigid curve");
    if (!stress.hinges.empty()) refuse(stress.hinges[0].location, "a hinge");
    if (stress.inertia_relief) refuse({}, "inertia relief");
    for (const SceneStress::Mass& mass : stress.masses)
      deck_.masses.push_back({mass.point, mass.mass});
    for (const Support& support : stress.supports) add(support);
    for (const Load& load : stress.loads)
      if (load.load_case == load_case) add(load);
    if (!areas_.empty())
      deck_.area_force = [areas = areas_](const std::string& region, const Vec3& x,
                                          const Vec3& n) -> Vec3 {
        Vec3 sum = Vec3::Zero();
        for (const AreaForce& of : areas)
          if ((of.region.empty() || of.region == region) && (!of.box || of.box->contains(x)))
            sum += of.force(x, n);
        return sum;
      };
    if (!temperatures_.empty()) add_temperature();
    return deck_;
  }

 private:
  struct AreaForce {
    std::string region;
    std::optional<Box3> box;
    std::function<Vec3(const Vec3& x, const Vec3& n)> force;
  };

  [[noreturn]] void refuse(const SourceLocation& location, const std::string& what) const {
    throw DeckLimitError(scene_.at(location) + "found " + what + ", which '" + file_ +
                         "' cannot contain");
  }

  static ShellDeck::Ply ply_of(const SceneMaterial& m, double thickness, double angle) {
    ShellDeck::Ply ply;
    ply.thickness = thickness;
    ply.angle = angle;
    ply.young = m.young;
    ply.young_across = m.is_orthotropic() ? m.young_across : m.young;
    ply.poisson = m.poisson;
    ply.shear = m.is_orthotropic() ? m.shear : m.young / (2 * (1 + m.poisson));
    ply.expansion = m.expansion[0];
    ply.expansion_across = m.expansion[1];
    ply.density = m.density;
    return ply;
  }

  void add_section() {
    const SceneStress& stress = *scene_.stress;
    deck_.thickness = stress.thickness;
    for (const ScenePly& ply : stress.plies)
      deck_.plies.push_back(
          ply_of(ply.material, ply.thickness, ply.angle * std::numbers::pi / 180));
    const SceneMaterial& material = stress.material;
    if (stress.plies.empty() &&
        (material.is_orthotropic() || material.expansion[0] != material.expansion[1]))
      deck_.plies.push_back(ply_of(material, stress.thickness, 0));
    if (!stress.along.isZero(0)) deck_.along = stress.along;
    deck_.young = material.young;
    deck_.poisson = material.poisson;
    deck_.density = material.density;
  }

  void add_temperature() {
    for (const Load& load : temperatures_)
      if (load.temperature_difference && !deck_.plies.empty())
        refuse(load.location, "a temperature difference through plies");
    deck_.expansion = scene_.stress->material.expansion[0];
    deck_.temperature = [loads = temperatures_, &scene = scene_](const Vec3& x) {
      std::array<double, 2> sum = {};
      for (const Load& load : loads)
        at_load(scene, load, [&] {
          if (load.temperature) sum[0] += (*load.temperature)(x);
          if (load.temperature_difference) sum[1] += (*load.temperature_difference)(x);
          return 0;
        });
      return sum;
    };
  }

  void add(const Support& support) {
    using Kind = Support::Kind;
    if (!support.region.text.empty()) find_region(layout_, scene_, support.region);
    if (support.kind == Kind::Elastic) return add_springs(support);
    ShellDeck::Support to;
    to.region = support.region.text;
    to.box = support.box;
    to.point = support.point;
    to.displacement = support.displacement;
    const bool on_curve = !support.line.text.empty();
    if (support.kind == Kind::Clamped && on_curve)
      to.rotation_axes = ShellDeck::Support::all_axes();
    if (support.kind == Kind::Prescribed) {
      to.directions = support.directions;
      if (support.rotation) to.rotations = ShellDeck::Support::Rotations::Tangent;
    }
    if (support.kind == Kind::Symmetric) {
      const Vec3 n = support.directions[0].normalized();
      const Vec3 first = n.unitOrthogonal();
      to.directions = {n};
      to.rotation_axes = {first, n.cross(first)};
    }
    if (support.axis)
      to.axes = [axes = CylindricalAxes{support.origin, *support.axis}](const Vec3& x) {
        return axes.at(x);
      };
    if (!on_curve) deck_.supports.push_back(to);
    for (const std::string& name : lines_of(support.line)) {
      to.line = name;
      deck_.supports.push_back(to);
    }
  }

  void add_springs(const Support& support) {
    ShellDeck::Spring spring;
    spring.region = support.region.text;
    spring.box = support.box;
    spring.point = support.point;
    spring.stiffness = support.springs;
    spring.foundation = support.foundation;
    if (support.line.text.empty()) deck_.springs.push_back(spring);
    for (const std::string& name : lines_of(support.line)) {
      spring.line = name;
      deck_.springs.push_back(spring);
    }
  }

  std::vector<std::string> lines_of(const LocatedString& line) const {
    if (line.text.empty()) return {};
    return find_lines(layout_, scene_, line);
  }

  using Point = ShellDeck::CurvePoint;
  void add_along(const Load& load, const std::function<Vec3(const Point&)>& force,
                 const std::function<Vec3(const Point&)>& moment = {}) {
    for (const std::string& name : lines_of(load.line))
      deck_.line_loads.push_back({name, force, moment, load.box});
  }

  void add(const Load& load) {
    if (!load.region.text.empty()) find_region(layout_, scene_, load.region);
    const Vec3 v = load.vector;
    const double value = load.value, level = load.level;
    const auto add_area = [&](const std::function<Vec3(const Vec3&, const Vec3&)>& force) {
      areas_.push_back({load.region.text, load.box, force});
    };
    switch (load.type) {
      case Load::Type::Pressure:
        if (load.box || !load.formulas.empty())
          add_area([load, &scene = scene_](const Vec3& x, const Vec3& n) -> Vec3 {
            return value_of(scene, load, x) * n;
          });
        else if (load.region.text.empty())
          deck_.pressure += value;
        else
          deck_.pressures.push_back({load.region.text, value});
        return;
      case Load::Type::Gravity:
        deck_.gravity += v;
        return;
      case Load::Type::AreaForce:
        return add_area([load, &scene = scene_](const Vec3& x, const Vec3&) {
          return vector_of(scene, load, x);
        });
      case Load::Type::Hydrostatic:
        return add_area([value, level](const Vec3& x, const Vec3& n) -> Vec3 {
          return value * std::max(0.0, level - x.z()) * n;
        });
      case Load::Type::Point:
        deck_.point_forces.push_back({load.point, v});
        return;
      case Load::Type::LineForce:
        return add_along(load, [load, &scene = scene_](const Point& at) {
          return vector_of(scene, load, at.x);
        });
      case Load::Type::LineMoment:
        return add_along(load, {}, [load, &scene = scene_](const Point& at) -> Vec3 {
          return value_of(scene, load, at.x) * at.tangent;
        });
      case Load::Type::EdgeForce:
        return add_along(load, [load, &scene = scene_](const Point& at) -> Vec3 {
          return value_of(scene, load, at.x) * at.outwards;
        });
      case Load::Type::Total:
        deck_.spread_loads.push_back(
            {lines_of(load.line), load.region.text, load.box, v, load.moment});
        return;
      case Load::Type::Temperature:
        if (!load.region.text.empty()) refuse(load.location, "a temperature of one face");
        if (load.temperature_difference && !deck_.thicknesses.empty())
          refuse(load.location, "a temperature difference in a shell of several thicknesses");
        temperatures_.push_back(load);
        return;
      case Load::Type::Spin:
        deck_.rotations.push_back({value, load.axis, load.origin});
        return;
    }
  }

  const Scene& scene_;
  const ModelLayout& layout_;
  std::string file_;
  ShellDeck deck_;
  std::vector<AreaForce> areas_;
  std::vector<Load> temperatures_;
};

}  // namespace

ShellDeck deck_of(const Scene& scene, const ModelLayout& layout, const std::string& load_case,
                  const std::string& file) {
  return DeckOfScene(scene, layout, file).made(load_case);
}

}  // namespace batten
