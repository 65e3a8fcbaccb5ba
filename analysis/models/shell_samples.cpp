// SPDX-License-Identifier: MPL-2.0
#include "batten/analysis/models/shell_samples.h"

#include "batten/analysis/models/line_sides.h"
#include "batten/analysis/models/part_quadrature.h"
#include "batten/analysis/shell_section.h"

namespace batten {

std::vector<CurveSample> sample_curve(const ModelLayout& model, const Points& shape,
                                      const std::string& line, int per_element) {
  LineSides sides(model);
  const ModelLine& of = model.model_line(line);
  const JoinEdge side = sides(of);
  const int first = model.first_triangle(of.sides[0].region);
  const Surface surface = model.surface(shape);
  std::vector<double> stations = side.stations();
  stations.insert(stations.begin(), 0.0);
  stations.push_back(1.0);
  std::vector<CurveSample> samples;
  const auto add = [&](double f) {
    CurveSample sample;
    sample.where = side.where(f);
    sample.where.triangle += first;
    const SurfaceJet jet = surface.jet(sample.where);
    const Vec2 along = side.along_uv(f);
    sample.at = jet.x;
    sample.tangent = (along.x() * jet.x_u + along.y() * jet.x_v).normalized();
    if (!samples.empty())
      sample.length = samples.back().length + (sample.at - samples.back().at).norm();
    samples.push_back(std::move(sample));
  };
  constexpr double shortest = 1e-9;
  for (size_t k = 0; k + 1 < stations.size(); ++k) {
    if (stations[k + 1] - stations[k] < shortest) continue;
    for (int i = 0; i < per_element; ++i)
      add(lerp(stations[k], stations[k + 1], static_cast<double>(i) / per_element));
  }
  add(1);
  return samples;
}

std::vector<AreaSample> sample_face(const ModelLayout& model, const Points& shape, int region) {
  const Surface surface = model.surface(shape);
  constexpr int degree = 4;
  const TabulatedRule whole(surface.kind(), symmetric_triangle_rule(degree + 2));
  std::vector<AreaSample> samples;
  for_each_part_point(model, surface, ShellPart{{region}, {}}, whole, degree,
                      [&](const PartPoint& at) {
                        samples.push_back({at.where, at.area.norm()});
                      });
  return samples;
}

}  // namespace batten
