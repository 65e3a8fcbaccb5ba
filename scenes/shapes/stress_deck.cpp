// SPDX-License-Identifier: MPL-2.0
// [stress] of a scene as a CalculiX deck.
#include <algorithm>
#include <array>
#include <functional>
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
    deck_.thickness = stress.thickness;
    if (!stress.plies.empty()) refuse({}, "a laminate");
    deck_.young = stress.material.young;
    deck_.poisson = stress.material.poisson;
    deck_.density = stress.material.density;
    // With the OFFSET of a section, ccx applies nodal forces in the middle of the shell all the same.
    if (stress.offset != 0) refuse({}, "a reference surface at the top or bottom");
    deck_.units = "lengths in " + scene_.unit;
    if (stress.material.is_orthotropic()) refuse({}, "an orthotropic material");
    for (const auto& of : stress.thicknesses) {
      if (of.region.text.empty()) refuse({}, "a variable thickness");
      find_region(layout_, scene_, of.region);
      deck_.thicknesses.push_back({of.region.text, of.thickness});
    }
    if (!stress.stiffeners.empty()) refuse(stress.stiffeners[0].line.location, "a stiffener");
    if (!stress.rigid_curves.empty()) refuse(stress.rigid_curves[0].location, "a rigid curve");
    if (!stress.masses.empty()) refuse(stress.masses[0].location, "a point mass");
    if (!stress.hinges.empty()) refuse(stress.hinges[0].location, "a hinge");
    if (stress.supports.empty()) refuse({}, "a shell without supports");
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

  void add_temperature() {
    const SceneMaterial& material = scene_.stress->material;
    if (material.expansion[0] != material.expansion[1])
      refuse({}, "different thermal expansions along and across");
    deck_.expansion = material.expansion[0];
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
    if (support.kind == Kind::Elastic) refuse(support.location, "an elastic support");
    if (support.kind == Kind::Symmetric) refuse(support.location, "a symmetry support");
    if (support.point) refuse(support.location, "a point support");
    if (support.axis) refuse(support.location, "a support in cylindrical directions");
    ShellDeck::Support to;
    to.kind = support.kind == Kind::Clamped && !support.line.text.empty()
                  ? ShellDeck::Support::Kind::Clamped
                  : ShellDeck::Support::Kind::Pinned;
    if (support.kind == Kind::Prescribed) {
      if (support.rotation) refuse(support.location, "a support that prescribes a rotation only");
      to.constrained = {false, false, false};
      for (const Vec3& d : support.directions) {
        int c;
        if (d.cwiseAbs().maxCoeff(&c) < d.norm())
          refuse(support.location, "a direction that is not a coordinate axis");
        to.constrained[c] = true;
      }
    }
    to.box = support.box;
    to.displacement = support.displacement;
    if (!support.region.text.empty()) {
      find_region(layout_, scene_, support.region);
      to.region = support.region.text;
    }
    if (support.line.text.empty()) deck_.supports.push_back(to);
    for (const std::string& name : lines_of(support.line)) {
      to.line = name;
      deck_.supports.push_back(to);
    }
  }

  std::vector<std::string> lines_of(const LocatedString& line) const {
    if (line.text.empty()) return {};
    return find_lines(layout_, scene_, line);
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
        if (!load.formulas.empty()) refuse(load.location, "a force that varies along a curve");
        for (const std::string& name : lines_of(load.line))
          deck_.line_forces.push_back({name, v, load.box});
        return;
      case Load::Type::LineMoment:
        refuse(load.location, "a line moment");
      case Load::Type::EdgeForce:
        refuse(load.location, "an edge force");
      case Load::Type::Total:
        refuse(load.location, "a total force or moment");
      case Load::Type::Temperature:
        if (!load.region.text.empty()) refuse(load.location, "a temperature of one face");
        if (load.temperature_difference && !deck_.thicknesses.empty())
          refuse(load.location, "a temperature difference in a shell of several thicknesses");
        temperatures_.push_back(load);
        return;
      case Load::Type::Spin:
        refuse(load.location, "a centrifugal load");
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
