#include "batten/apps/commands/shapes/stress_deck.h"

#include <algorithm>
#include <functional>

#include "batten/apps/commands/shapes/stress_setup.h"

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
    deck_.young = stress.young;
    deck_.poisson = stress.poisson;
    deck_.density = stress.density;
    deck_.units = "lengths in " + scene_.unit;
    if (stress.young_across > 0) refuse({}, "an orthotropic material");
    for (const auto& of : stress.thicknesses) {
      if (of.region.text.empty()) refuse({}, "a thickness that fades");
      find_region(layout_, scene_, of.region);
      deck_.thicknesses.push_back({of.region.text, of.thickness});
    }
    if (!stress.hinges.empty()) refuse(stress.hinges[0].location, "a hinge");
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
    return deck_;
  }

 private:
  struct AreaForce {
    std::string region;
    std::optional<Box3> box;
    std::function<Vec3(const Vec3& x, const Vec3& n)> force;
  };

  [[noreturn]] void refuse(const SourceLocation& location, const std::string& what) const {
    throw InputError(scene_.at(location) + "found " + what + ", which '" + file_ +
                     "' cannot hold; `batten stress` can");
  }

  void add(const Support& support) {
    using Kind = Support::Kind;
    if (support.kind == Kind::Elastic) refuse(support.location, "springs");
    if (support.kind == Kind::Symmetric) refuse(support.location, "a plane of symmetry");
    if (support.point) refuse(support.location, "a support at a point");
    ShellDeck::Support to;
    to.kind = support.kind == Kind::Clamped && !support.line.text.empty()
                  ? ShellDeck::Support::Kind::Clamped
                  : ShellDeck::Support::Kind::Pinned;
    if (support.kind == Kind::Prescribed) {
      if (support.rotation) refuse(support.location, "a rotation that is held alone");
      to.constrained = {false, false, false};
      for (const Vec3& d : support.directions) {
        int c;
        if (d.cwiseAbs().maxCoeff(&c) < d.norm())
          refuse(support.location, "a direction off the axes");
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
        if (load.box)
          add_area([value](const Vec3&, const Vec3& n) -> Vec3 { return value * n; });
        else if (load.region.text.empty())
          deck_.pressure += value;
        else
          deck_.pressures.push_back({load.region.text, value});
        return;
      case Load::Type::Gravity:
        deck_.gravity += v;
        return;
      case Load::Type::AreaForce:
        return add_area([v](const Vec3&, const Vec3&) { return v; });
      case Load::Type::Hydrostatic:
        return add_area([value, level](const Vec3& x, const Vec3& n) -> Vec3 {
          return value * std::max(0.0, level - x.z()) * n;
        });
      case Load::Type::Point:
        deck_.point_forces.push_back({load.point, v});
        return;
      case Load::Type::LineForce:
        for (const std::string& name : lines_of(load.line))
          deck_.line_forces.push_back({name, v, load.box});
        return;
      case Load::Type::LineMoment:
        refuse(load.location, "a moment along a line");
    }
  }

  const Scene& scene_;
  const ModelLayout& layout_;
  std::string file_;
  ShellDeck deck_;
  std::vector<AreaForce> areas_;
};

}  // namespace

ShellDeck deck_of(const Scene& scene, const ModelLayout& layout, const std::string& load_case,
                  const std::string& file) {
  return DeckOfScene(scene, layout, file).made(load_case);
}

}  // namespace batten
