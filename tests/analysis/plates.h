// SPDX-License-Identifier: MPL-2.0
// Plates between straight lines, with exact beam solutions.
#pragma once

#include <string>
#include <vector>

#include "batten/tests/support/test_model_builder.h"

namespace batten_test {

/// Plates of width W between straight lines in y from 0 to W; these lines have names.
struct Plates {
  static constexpr double W = 0.5, E = 1000, t = 0.02, q = 1e-4;
  static constexpr double EI = E * t * t * t / 12;
  TestModelBuilder builder;
  double h = 0.1;

  void across(const std::string& name, const Vec3& at_0, const Vec3& at_W) {
    line(name, at_0, at_W + Vec3(0, W, 0));
  }
  void line(const std::string& name, const Vec3& a, const Vec3& b) {
    const Vec3 d = b - a;
    const auto curve = curve_from_formula(0, 1, [=](double s, int order) -> Vec3 {
      return order == 0 ? Vec3(a + s * d) : order == 1 ? d : Vec3(0, 0, 0);
    });
    builder.add(prescribed_line(name, curve, 1, h));
  }
  // A plate between two of these lines.
  void plate(const std::string& from, const std::string& to) {
    const auto end = [&](const std::string& name, double s) {
      return builder.lines.at(name).curve->evaluate(s);
    };
    line(from + to + " 0", end(from, 0), end(to, 0));
    line(from + to + " W", end(from, 1), end(to, 1));
    builder.region({from, from + to + " W", to, from + to + " 0"});
  }
  Plates() { builder.options.edge_length = h; }
};

/// One plate of a given length in x and width Plates::W in y, with its elements.
struct SinglePlate {
  /// The supported lines: x = 0, x = length, y = 0 and y = W.
  inline static const std::vector<std::string> edges = {"a", "b", "ab 0", "ab W"};
  Plates plates;
  ModelLayout layout;
  Points shape;
  double length;

  SinglePlate(double plate_length, double edge_length)
      : plates(lines(plate_length, edge_length)),
        layout(plates.builder.model({})),
        shape(layout.all_dofs(plates.builder.first)),
        length(plate_length) {}

 private:
  static Plates lines(double length, double edge_length) {
    Plates p;
    p.h = p.builder.options.edge_length = edge_length;
    p.across("a", {0, 0, 0}, {0, 0, 0});
    p.across("b", {length, 0, 0}, {length, 0, 0});
    p.plate("a", "b");
    return p;
  }
};

}  // namespace batten_test
