#include "batten/fairing/variation_terms.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "batten/core/errors.h"
#include "batten/core/isize.h"
#include "batten/core/parallel_chunks.h"
#include "batten/fairing/variation_geometry.h"

namespace batten {

CurvatureVariationTerms::CurvatureVariationTerms(const Surface& start, double gauss, double jumps,
                                                 const std::vector<char>& frozen)
    : gauss_(gauss),
      jumps_(jumps),
      length_(std::sqrt(start.area())),
      weights_(start.mesh().triangle_count(), 1),
      frames_(9 * static_cast<size_t>(start.mesh().triangle_count())),
      twists_(start.mesh().triangle_count(), Vec3::Zero()) {
  constexpr double outside = 1e-6;  // of a trimmed surface; keeps the matrix definite
  for (int t = 0; t < isize(weights_); ++t) {
    if (start.trim()) weights_[t] = std::max(outside, start.trim()->area_fraction(t));
    if (!frozen.empty() && frozen[t]) weights_[t] = 0;
  }
  const auto& edges = start.mesh().edges();
  for (int e = 0; e < isize(edges); ++e)
    if (!edges[e].boundary() && weights_[edges[e].triangle[0]] > 0 &&
        weights_[edges[e].triangle[1]] > 0)
      edges_.push_back(e);
  set_frames(start);
}

void CurvatureVariationTerms::set_frames(const Surface& surface) {
  const int count = surface.mesh().triangle_count();
  const auto& tables = HctTables::get();
  std::vector<double> split(frames_.size()), sums(count), areas(count);
  parallel_for_each<16>(count, [&](int t) {
    if (weights_[t] == 0) return;
    const TriangleDofs q = reference_map(surface, t).lazyProduct(surface.triangle_dofs(t));
    for (int p = 0; p < 9; ++p) {
      const Jet3 jet = q.transpose().lazyProduct(tables.inside[p]);
      Frame& frame = frames_[9 * t + p];
      frame.M = principal_frame(jet);
      const CurvatureTensors forms = curvature_tensors(jet, frame.M);
      split[9 * t + p] = 0.5 * (forms.II[0] - forms.II[2]);
      const double dA = weights_[t] * forms.jacobian;
      sums[t] += 0.5 * dA * (forms.II[0] * forms.II[0] + forms.II[2] * forms.II[2]);
      areas[t] += dA;
    }
  });
  double sum = 0, area = 0;
  for (int t = 0; t < count; ++t) {
    sum += sums[t];
    area += areas[t];
  }
  if (!std::isfinite(sum))
    throw InputError("the surface to be faired has a point without a normal");
  // A hundredth of the mean curvature is no difference of principal curvatures.
  const double floor = 1e-4 * sum / area;
  for (size_t p = 0; p < frames_.size(); ++p) {
    const double square = split[p] * split[p];
    frames_[p].principal = square > 0 ? square / (square + floor) : 0;
  }
}

void CurvatureVariationTerms::add_side(const Surface& start, const std::vector<int>& vertices) {
  const ParametricMesh& mesh = start.mesh();
  const auto& tables = HctTables::get();
  struct Sample {
    double ds;
    Vec3 curvature;
  };
  std::vector<Sample> samples;
  std::vector<int> edges;
  double length = 0, turn = 0;
  for (size_t i = 0; i + 1 < vertices.size(); ++i) {
    const int e = mesh.edge_between(vertices[i], vertices[i + 1]);
    if (e < 0) throw InputError("a side of the outline is not a chain of edges");
    edges.push_back(e);
    const int t = mesh.edges()[e].triangle[0], local = mesh.edges()[e].local[0];
    const Vec2 direction = edge_direction(local);
    const TriangleDofs q = reference_map(start, t).lazyProduct(start.triangle_dofs(t));
    for (size_t k = 0; k < 3; ++k) {
      const LocalJet jet = local_jet(q, tables.edges3[local][k]);
      const Vec3 d1 = jet.leftCols<2>() * direction,
                 d2 = jet.rightCols<3>() * second_derivative_weights(direction);
      const double ds = HctTables::weight3[k] * d1.norm();
      samples.push_back({ds, d1.cross(d2) / std::pow(d1.norm(), 3)});
      length += ds;
      turn += ds * edge_second_form(jet, direction).twist;
    }
  }
  Vec3 mean = Vec3::Zero();
  for (const Sample& s : samples) mean += s.ds / length * s.curvature;
  double spread = 0;
  for (const Sample& s : samples) spread += s.ds / length * (s.curvature - mean).squaredNorm();
  const double uneven = length * std::sqrt(spread) / (1 + length * mean.norm());
  turn = std::remainder(turn, 2 * std::numbers::pi);
  const double gate = (1 + std::pow(turn / 0.05, 2)) * (1 + std::pow(uneven / 0.1, 2));
  for (const int e : edges)
    twists_[mesh.edges()[e].triangle[0]][mesh.edges()[e].local[0]] = 3 / (length_ * gate);
}

CurvatureVariationWeights CurvatureVariationTerms::weights_at(int triangle, int point) const {
  return {frames_[9 * triangle + point].principal, 1e-4 / (length_ * length_), gauss_};
}

double CurvatureVariationTerms::edge_weight(const Surface& surface, int e) const {
  const auto& edge = surface.mesh().edges()[e];
  return 0.5 * (weights_[edge.triangle[0]] + weights_[edge.triangle[1]]);
}

double CurvatureVariationTerms::value(const Surface& surface) const {
  const int triangles = surface.mesh().triangle_count(), edges = triangles + isize(edges_);
  std::vector<double> parts(edges + joins_.size());
  parallel_for_each<64>(isize(parts), [&](int i) {
    parts[i] = i < triangles ? triangle_value(surface, i)
               : i < edges   ? edge_value(surface, edges_[i - triangles])
                             : join_value(surface, joins_[i - edges]);
  });
  double sum = 0;
  for (const double part : parts) sum += part;
  return std::isfinite(sum) ? sum : std::numeric_limits<double>::infinity();
}

double CurvatureVariationTerms::triangle_value(const Surface& surface, int t) const {
  if (weights_[t] == 0) return 0;
  const auto& tables = HctTables::get();
  const TriangleDofs q = reference_map(surface, t).lazyProduct(surface.triangle_dofs(t));
  double sum = 0;
  for (int p = 0; p < 9; ++p) {
    const Jet3 jet = q.transpose().lazyProduct(tables.inside[p]);
    sum += kPointWeight * curvature_variation_residuals(
                              curvature_tensors(jet, frames_[9 * t + p].M), weights_at(t, p))
                              .squaredNorm();
  }
  for (int i = 0; i < 3; ++i)
    for (const auto& point : tables.spokes[i]) {
      const Vec2 across = edge_direction(i);
      const Vec3 jump = q.transpose() * (point.jump * second_derivative_weights(across));
      const double r = curvature_jump(q.transpose().lazyProduct(point.slopes), jump,
                                      spoke_direction(i), across, kSpokeThickness, jumps_)
                           .value;
      sum += r * r;
    }
  for (int i = 0; i < 3; ++i)
    for (size_t k = 0; k < 3 && twists_[t][i] > 0; ++k) {
      const LocalJet jet = local_jet(q, tables.edges3[i][k]);
      const double ds = HctTables::weight3[k] * (jet.leftCols<2>() * edge_direction(i)).norm();
      sum += twists_[t][i] * ds * std::pow(edge_second_form(jet, edge_direction(i)).twist, 2);
    }
  return weights_[t] * sum;
}

}  // namespace batten
