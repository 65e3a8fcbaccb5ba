// SPDX-License-Identifier: MPL-2.0
#include "batten/sculpting/loads/loads.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "batten/core/box_tree.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/core/parallel.h"
#include "batten/elements/reference_triangle.h"
#include "batten/skinning/model/model_layout.h"

namespace batten {
namespace {

constexpr int kPoints = 7;  // number of quadrature points per triangle
using TrianglePoints = Eigen::Matrix<double, kPoints, 3>;

double bump(double distance2, double radius) {
  const double ratio = distance2 / (radius * radius);
  return ratio < 1 ? (1 - ratio) * (1 - ratio) : 0;
}

double distance2_to_chord(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 d = b - a;
  const double length2 = d.squaredNorm();
  const double s = length2 > 0 ? std::clamp((p - a).dot(d) / length2, 0.0, 1.0) : 0;
  return (a + s * d - p).squaredNorm();
}

// Polyline whose chords deviate from the curve by at most `sagitta`.
std::vector<Vec3> polyline_of(const HermiteCurve& curve, double sagitta) {
  std::vector<Vec3> chain{curve.evaluate({0, 0.0})};
  for (int s = 0; s < curve.segment_count(); ++s) {
    // X'' is linear in a segment: largest at an end.
    const double second_derivative = std::max(curve.evaluate({s, 0.0}, 2).norm(),
                                              curve.evaluate({s, 1.0}, 2).norm()),
                 h = curve.mesh().length(s);
    constexpr double most = 10000;
    const int cuts = static_cast<int>(
        std::clamp(std::ceil(h * std::sqrt(second_derivative / (8 * sagitta))), 1.0, most));
    for (int k = 1; k <= cuts; ++k) chain.push_back(curve.evaluate({s, double(k) / cuts}));
  }
  return chain;
}

class DistanceToPolyline {
 public:
  DistanceToPolyline(std::vector<Vec3> chain, double radius)
      : chain_(std::move(chain)), radius_(radius) {
    std::vector<Box3> boxes;
    for (size_t i = 0; i + 1 < chain_.size(); ++i)
      boxes.push_back(Box3(chain_[i]).extend(chain_[i + 1]));
    chords_ = BoxTree<3>(boxes);
  }

  Eigen::Matrix<double, kPoints, 1> weights(const TrianglePoints& x) const {
    Box3 here;
    for (int p = 0; p < kPoints; ++p) here.extend(x.row(p).transpose());
    Eigen::Matrix<double, kPoints, 1> nearest =
        Eigen::Matrix<double, kPoints, 1>::Constant(radius_ * radius_);
    chords_.for_each_near(here, radius_, [&](int i) {
      for (int p = 0; p < kPoints; ++p)
        nearest[p] = std::min(nearest[p], distance2_to_chord(x.row(p), chain_[i], chain_[i + 1]));
    });
    return nearest.unaryExpr([&](double d2) { return bump(d2, radius_); });
  }

 private:
  std::vector<Vec3> chain_;
  double radius_;
  BoxTree<3> chords_;
};

void require_radius(double radius, const std::string& what) {
  if (!(radius > 0) || !std::isfinite(radius))
    throw InputError(what + ": found the radius " + format_number(radius) +
                     ", expected a length above 0");
}

// Mean over every triangle of the 7 values weights(points of the triangle).
template <class Weights>
VecX triangle_means(const Surface& reference, const Weights& weights) {
  constexpr int degree = 5;
  const TabulatedRule rule(reference.kind(), symmetric_triangle_rule(degree));
  Eigen::Matrix<double, kPoints, 12> N;
  for (int p = 0; p < kPoints; ++p) N.row(p) = rule.functions[p].col(0);
  const ParametricMesh& mesh = reference.mesh();
  VecX result(mesh.triangle_count());
  parallel_for_each<256>(mesh.triangle_count(), [&](int t) {
    const C1Triangle element(reference.kind(), mesh.shape(t));
    const TrianglePoints x = N * element.pull_back(reference.triangle_dofs(t));
    result[t] = std::clamp(rule.rule.weights.dot(weights(x)), 0.0, 1.0);
  });
  return result;
}

VecX near_line(const Area::NearLine& area, const ModelLayout& layout, const Surface& reference) {
  const HermiteCurve& line = layout.line(area.line);
  require_radius(area.radius, "the area near curve '" + area.line + "'");
  constexpr double precise = 1e-3;
  const DistanceToPolyline chain(polyline_of(line, precise * area.radius), area.radius);
  return triangle_means(reference, [&](const TrianglePoints& x) { return chain.weights(x); });
}

VecX painted(const Area::Painted& area, const Surface& reference) {
  if (area.strokes.empty()) throw InputError("a painted area has no strokes, expected one or more");
  for (size_t s = 0; s < area.strokes.size(); ++s) {
    const auto& stroke = area.strokes[s];
    const std::string what = "stroke " + std::to_string(s + 1) + " of a painted area";
    require_radius(stroke.radius, what);
    if (!stroke.at.allFinite() || !std::isfinite(stroke.strength))
      throw InputError(what + ": its point and strength must be finite");
  }
  return triangle_means(reference, [&](const TrianglePoints& x) {
    Eigen::Matrix<double, kPoints, 1> w = Eigen::Matrix<double, kPoints, 1>::Zero();
    for (const auto& stroke : area.strokes)
      for (int p = 0; p < kPoints; ++p) {
        const double distance2 = (x.row(p).transpose() - stroke.at).squaredNorm();
        w[p] = std::clamp(w[p] + stroke.strength * bump(distance2, stroke.radius), 0.0, 1.0);
      }
    return w;
  });
}

}  // namespace

VecX triangle_weights(const Area& area, const ModelLayout& layout, const Surface& reference) {
  if (reference.mesh().triangle_count() != layout.mesh()->triangle_count() ||
      reference.mesh().vertex_count() != layout.mesh()->vertex_count())
    throw InputError("found a reference shape of " +
                     std::to_string(reference.mesh().triangle_count()) + " triangles, expected " +
                     std::to_string(layout.mesh()->triangle_count()) + " of model '" +
                     layout.name() + "'");
  const auto anywhere = [&]() -> VecX {
    if (const auto* near = std::get_if<Area::NearLine>(&area.where))
      return near_line(*near, layout, reference);
    if (const auto* paint = std::get_if<Area::Painted>(&area.where))
      return painted(*paint, reference);
    return VecX::Ones(reference.mesh().triangle_count());
  };
  VecX weights = anywhere();
  if (area.regions.empty()) return weights;
  std::vector<char> named(static_cast<size_t>(layout.region_count()), 0);
  for (const std::string& region : area.regions) named[layout.region_named(region)] = 1;
  for (int r = 0; r < layout.region_count(); ++r)
    if (!named[r])
      weights.segment(layout.first_triangle(r), layout.region(r).mesh()->triangle_count())
          .setZero();
  return weights;
}

namespace {

std::vector<Vec2> directions_along(const HermiteCurve& pcurve, const ParametricMesh& mesh) {
  constexpr int cuts = 16;  // chords per segment
  std::vector<Vec2> chain{drop_z(pcurve.evaluate({0, 0.0}))};
  for (int s = 0; s < pcurve.segment_count(); ++s)
    for (int k = 1; k <= cuts; ++k)
      chain.push_back(drop_z(pcurve.evaluate({s, static_cast<double>(k) / cuts})));
  std::vector<Vec2> directions(static_cast<size_t>(mesh.triangle_count()));
  parallel_for_each<256>(mesh.triangle_count(), [&](int t) {
    const Vec2 centre = mesh.shape(t).point(Vec3::Constant(1.0 / 3));
    double nearest = std::numeric_limits<double>::infinity();
    CurveMesh::SegmentPoint where;
    Vec2 chord = Vec2::UnitX();
    for (size_t i = 0; i + 1 < chain.size(); ++i) {
      const Vec2 d = chain[i + 1] - chain[i];
      const double length2 = d.squaredNorm();
      const double s = length2 > 0 ? std::clamp((centre - chain[i]).dot(d) / length2, 0.0, 1.0) : 0;
      const double distance2 = (chain[i] + s * d - centre).squaredNorm();
      if (!(distance2 < nearest)) continue;
      nearest = distance2;
      const auto index = static_cast<int>(i);
      where = {index / cuts, (index % cuts + s) / cuts};
      chord = d;
    }
    const Vec2 slope = drop_z(pcurve.evaluate(where, 1));
    directions[t] = (slope.norm() > 0 ? slope : chord).normalized();
  });
  return directions;
}

}  // namespace

std::vector<Vec2> triangle_directions(const std::string& line, const ModelLayout& layout) {
  std::vector<Vec2> directions(static_cast<size_t>(layout.mesh()->triangle_count()), Vec2::Zero());
  for (const LineSide& side : layout.model_line(line).sides) {
    const auto own = directions_along(layout.pcurve(side), *layout.region(side.region).mesh());
    std::copy(own.begin(), own.end(), directions.begin() + layout.first_triangle(side.region));
  }
  return directions;
}

}  // namespace batten
