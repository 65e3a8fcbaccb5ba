// SPDX-License-Identifier: MPL-2.0
// Models of a few faces on their own curves, for tests.
#pragma once

#include <map>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "batten/core/errors.h"
#include "batten/skinning/model/model_layout.h"
#include "batten/tests/support/prescribed_lines.h"

namespace batten_test {
using namespace batten;

/// Faces by the names of their curves. The outline follows the first one (or, with a '-' before it,
/// runs in the opposite direction).
struct TestModelBuilder {
  std::map<std::string, CharacterLine> lines;
  std::vector<std::shared_ptr<const RegionLayout>> layouts;
  std::vector<Points> first;  ///< shapes from the curves alone
  SkinOptions options;
  double size = 1;

  void add(CharacterLine line) {
    const std::string name = line.name;
    lines.emplace(name, std::move(line));
  }
  void region(std::vector<std::string> names) {
    SkinOptions o = options;
    o.reverse_orientation = names[0][0] == '-';
    if (o.reverse_orientation) names[0].erase(0, 1);
    std::vector<CharacterLine> used;
    for (const auto& n : names) used.push_back(lines.at(n));
    layouts.push_back(std::make_shared<const RegionLayout>(
        "region " + std::to_string(layouts.size() + 1), used, o));
    first.push_back(ModelLayout({"one", size}, {layouts.back()}, {}).minimize_energy({}));
  }
  JoinSide side(int r, const std::string& name) const {
    const SkinnedRegion made =
        layouts[static_cast<size_t>(r)]->region(first[static_cast<size_t>(r)]);
    for (const auto& loop : made.boundary)
      for (const auto& piece : loop) {
        const bool embedded = piece.kind == BoundarySegment::Kind::Embedded;
        const auto i = static_cast<size_t>(piece.index);
        if ((embedded ? made.embedded[i].line.name : made.edge_aligned[i].line.name) == name)
          return {r, embedded, piece.index,
                  piece.reversed == (embedded && made.embedded[i].opposite_to_prescribed)};
      }
    throw InputError("region " + std::to_string(r + 1) + " has no line '" + name + "'");
  }
  JoinLine join_line(const std::string& name, int a, int b) const {
    return {name, {side(a, name), side(b, name)}};
  }
  std::vector<JoinPlan> plan(const std::vector<JoinLine>& join_lines) const {
    std::vector<const RegionLayout*> all;
    for (const auto& layout : layouts) all.push_back(layout.get());
    return plan_joins(all, first, join_lines, 0.1);
  }
  ModelLayout model(const std::vector<JoinLine>& join_lines) const {
    return {{"model", size, 1e-4 * size, Vec3(0.3, 0.2, 0.1)}, layouts, plan(join_lines)};
  }
};

inline std::shared_ptr<const InputCurve> quarter(const Vec3& a, const Vec3& b) {
  return curve_from_formula(0, std::numbers::pi / 2, [=](double t, int order) -> Vec3 {
    if (order == 0) return a * std::cos(t) + b * std::sin(t);
    if (order == 1) return -a * std::sin(t) + b * std::cos(t);
    return -a * std::cos(t) - b * std::sin(t);
  });
}

/// Two octants of the unit sphere that share the curve "zx".
inline TestModelBuilder octants(double h) {
  const Vec3 x = Vec3::UnitX(), y = Vec3::UnitY(), z = Vec3::UnitZ();
  TestModelBuilder p;
  p.options.edge_length = h;
  for (const auto& [name, a, b] : {std::tuple<const char*, Vec3, Vec3>{"zx", z, x},
                                   {"xy", x, y},
                                   {"yz", y, z},
                                   {"x-y", x, -y},
                                   {"-yz", -y, z}})
    p.add(prescribed_line(name, quarter(a, b), 3, h));
  p.region({"zx", "xy", "yz"});
  p.region({"-zx", "x-y", "-yz"});
  return p;
}

}  // namespace batten_test
