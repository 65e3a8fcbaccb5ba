// SPDX-License-Identifier: MPL-2.0
// Prescribed curves for tests, as a network passes them on.
#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "batten/fairing/curves/curve_fit.h"
#include "batten/skinning/layout/region_layout.h"
#include "batten/tests/support/sample_lines.h"

namespace batten_test {

/// The curve resampled uniformly in arc length / size, with vertices at most `edge` apart.
inline CharacterLine prescribed_line(const std::string& name,
                                     const std::shared_ptr<const InputCurve>& curve, double size,
                                     double edge) {
  FitOptions fit;
  fit.tolerance = 1e-4 * size;
  fit.corner_angle = 180;
  fit.fixed_parameters = true;
  fit.closed = false;
  fit.start = {curve->evaluate(curve->start()), curve->evaluate(curve->start(), 1).normalized()};
  fit.end = {curve->evaluate(curve->end()), curve->evaluate(curve->end(), 1).normalized()};
  const HermiteCurve fitted = fit_curve(name, curve, fit);
  std::vector<double> nodes;
  for (const double u : fitted.parameters())
    nodes.push_back(std::round(u / size * (1 << 30)) / (1 << 30));
  Points x(fitted.node_count(), 3), d(fitted.node_count(), 3);
  for (int i = 0; i < fitted.node_count(); ++i) {
    x.row(i) = fitted.position(i);
    d.row(i) = size * fitted.slope_out(i).normalized();
  }
  PrescribedCurve prescribed{HermiteCurve(nodes, x, d), {}};
  for (size_t i = 0; i + 1 < nodes.size(); ++i) {
    const int cuts =
        std::max(1, static_cast<int>(std::ceil((nodes[i + 1] - nodes[i]) * size / edge - 0.2)));
    for (int k = 0; k < cuts; ++k)
      prescribed.vertices.push_back(nodes[i] + (nodes[i + 1] - nodes[i]) * k / cuts);
  }
  prescribed.vertices.push_back(nodes.back());
  CharacterLine line{name, curve};
  line.prescribed = std::make_shared<const PrescribedCurve>(std::move(prescribed));
  return line;
}

}  // namespace batten_test
