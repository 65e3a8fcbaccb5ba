#include "batten/fairing/variation_terms.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "batten/core/chunks.h"
#include "batten/core/errors.h"
#include "batten/core/index.h"
#include "batten/fairing/variation_geometry.h"

namespace batten {

VariationTerms::VariationTerms(const Surface& start, double gauss, double jumps,
                               const std::vector<char>& still)
    : gauss_(gauss),
      jumps_(jumps),
      length_(std::sqrt(start.area())),
      shares_(start.mesh().triangle_count(), 1),
      frames_(9 * static_cast<size_t>(start.mesh().triangle_count())),
      twists_(start.mesh().triangle_count(), Vec3::Zero()) {
  constexpr double outside = 1e-6;  // of a trimmed surface; keeps the matrix definite
  for (int t = 0; t < count_of(shares_); ++t) {
    if (start.trim()) shares_[t] = std::max(outside, start.trim()->share(t));
    if (!still.empty() && still[t]) shares_[t] = 0;
  }
  const auto& edges = start.mesh().edges();
  for (int e = 0; e < count_of(edges); ++e)
    if (!edges[e].boundary() && shares_[edges[e].triangle[0]] > 0 &&
        shares_[edges[e].triangle[1]] > 0)
      edges_.push_back(e);
  set_frames(start);
}

void VariationTerms::set_frames(const Surface& surface) {
  const int count = surface.mesh().triangle_count();
  const auto& tables = HctTables::get();
  std::vector<double> split(frames_.size()), sums(count), areas(count);
  for_each_in_chunks<16>(count, [&](int t) {
    if (shares_[t] == 0) return;
    const TriangleDofs q = reference_map(surface, t).lazyProduct(surface.triangle_dofs(t));
    for (int p = 0; p < 9; ++p) {
      const Jet3 jet = q.transpose().lazyProduct(tables.inside[p]);
      Frame& frame = frames_[9 * t + p];
      frame.M = principal_frame(jet);
      const CurvatureForms forms = curvature_forms(jet, frame.M);
      split[9 * t + p] = 0.5 * (forms.II[0] - forms.II[2]);
      const double dA = shares_[t] * forms.jacobian;
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

void VariationTerms::add_side(const Surface& start, const std::vector<int>& vertices) {
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
    const Vec2 way = edge_way(local);
    const TriangleDofs q = reference_map(start, t).lazyProduct(start.triangle_dofs(t));
    for (size_t k = 0; k < 3; ++k) {
      const LocalJet jet = local_jet(q, tables.edges3[local][k]);
      const Vec3 d1 = jet.leftCols<2>() * way, d2 = jet.rightCols<3>() * twice_along(way);
      const double ds = HctTables::weight3[k] * d1.norm();
      samples.push_back({ds, d1.cross(d2) / std::pow(d1.norm(), 3)});
      length += ds;
      turn += ds * line_forms(jet, way).twist;
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

ChangeWeights VariationTerms::weights_at(int triangle, int point) const {
  return {frames_[9 * triangle + point].principal, 1e-4 / (length_ * length_), gauss_};
}

double VariationTerms::share_beside(const Surface& surface, int e) const {
  const auto& edge = surface.mesh().edges()[e];
  return 0.5 * (shares_[edge.triangle[0]] + shares_[edge.triangle[1]]);
}

double VariationTerms::value(const Surface& surface) const {
  const int triangles = surface.mesh().triangle_count(), edges = triangles + count_of(edges_);
  std::vector<double> parts(edges + joins_.size());
  for_each_in_chunks<64>(count_of(parts), [&](int i) {
    parts[i] = i < triangles ? triangle_value(surface, i)
               : i < edges   ? edge_value(surface, edges_[i - triangles])
                             : join_value(surface, joins_[i - edges]);
  });
  double sum = 0;
  for (const double part : parts) sum += part;
  return std::isfinite(sum) ? sum : std::numeric_limits<double>::infinity();
}

double VariationTerms::triangle_value(const Surface& surface, int t) const {
  if (shares_[t] == 0) return 0;
  const auto& tables = HctTables::get();
  const TriangleDofs q = reference_map(surface, t).lazyProduct(surface.triangle_dofs(t));
  double sum = 0;
  for (int p = 0; p < 9; ++p) {
    const Jet3 jet = q.transpose().lazyProduct(tables.inside[p]);
    sum += kPointWeight *
           change_residuals(curvature_forms(jet, frames_[9 * t + p].M), weights_at(t, p))
               .squaredNorm();
  }
  for (int i = 0; i < 3; ++i)
    for (const auto& point : tables.spokes[i]) {
      const Vec2 across = edge_way(i);
      const Vec3 jump = q.transpose() * (point.jump * twice_along(across));
      const double r = jump_of(q.transpose().lazyProduct(point.slopes), jump, spoke_way(i), across,
                               kSpokeThickness, jumps_)
                           .value;
      sum += r * r;
    }
  for (int i = 0; i < 3; ++i)
    for (size_t k = 0; k < 3 && twists_[t][i] > 0; ++k) {
      const LocalJet jet = local_jet(q, tables.edges3[i][k]);
      const double ds = HctTables::weight3[k] * (jet.leftCols<2>() * edge_way(i)).norm();
      sum += twists_[t][i] * ds * std::pow(line_forms(jet, edge_way(i)).twist, 2);
    }
  return shares_[t] * sum;
}

}  // namespace batten
