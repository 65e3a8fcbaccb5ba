#include "batten/fem/curve.h"

#include <cmath>

#include "batten/core/errors.h"
#include "batten/elements/hermite_segment.h"
#include "batten/elements/quadrature.h"

namespace batten {
namespace {

Points interleaved(const std::vector<double>& parameters, const Points& positions,
                   const Points& derivatives) {
  const auto n = static_cast<long>(parameters.size());
  if (n < 2) throw InputError("a curve needs at least two nodes");
  if (positions.rows() != n || derivatives.rows() != n)
    throw InputError("a curve with " + std::to_string(n) + " parameters, " +
                     std::to_string(positions.rows()) + " positions and " +
                     std::to_string(derivatives.rows()) + " derivatives");
  Points dofs(2 * n, 3);
  for (long i = 0; i < n; ++i) {
    dofs.row(2 * i) = positions.row(i);
    dofs.row(2 * i + 1) = derivatives.row(i);
  }
  return dofs;
}

}  // namespace

HermiteCurve::HermiteCurve(CurveMesh mesh, Points dofs)
    : mesh_(std::move(mesh)), dofs_(std::move(dofs)) {
  if (dofs_.rows() != mesh_.dof_count())
    throw InputError(std::to_string(dofs_.rows()) + " dofs for a curve that has " +
                     std::to_string(mesh_.dof_count()));
  if (!dofs_.allFinite()) throw InputError("a curve node is not finite");
}

HermiteCurve::HermiteCurve(std::vector<double> parameters, const Points& positions,
                           const Points& derivatives)
    : HermiteCurve(CurveMesh(parameters), interleaved(parameters, positions, derivatives)) {}

Vec3 HermiteCurve::evaluate(CurveMesh::Where at, int order) const {
  const auto H = HermiteSegment(mesh_.length(at.segment)).evaluate(at.s, order);
  const auto dof = mesh_.segment_dofs(at.segment);
  return (H[0] * dofs_.row(dof[0]) + H[1] * dofs_.row(dof[1]) + H[2] * dofs_.row(dof[2]) +
          H[3] * dofs_.row(dof[3]))
      .transpose();
}

Vec3 HermiteCurve::evaluate(double u, int order) const { return evaluate(mesh_.where(u), order); }

double HermiteCurve::curvature(double u) const {
  const Vec3 d1 = evaluate(u, 1), d2 = evaluate(u, 2);
  const double speed = d1.norm();
  return speed > 0 ? d1.cross(d2).norm() / (speed * speed * speed) : 0;
}

double HermiteCurve::length() const {
  static const SegmentRule rule = gauss_legendre(8);
  double length = 0;
  for (int i = 0; i < segment_count(); ++i)
    for (long p = 0; p < rule.s.size(); ++p)
      length +=
          mesh_.length(i) * rule.weights[p] * evaluate(CurveMesh::Where{i, rule.s[p]}, 1).norm();
  return length;
}

CurvePoint HermiteCurve::closest_point(const Vec3& p) const {
  constexpr int samples = 8;
  std::vector<double> u = {start()};
  for (int i = 0; i < segment_count(); ++i) {
    for (int k = 1; k < samples; ++k) u.push_back(parameters()[i] + mesh_.length(i) * k / samples);
    u.push_back(parameters()[i + 1]);
  }
  return closest_on_curve([&](double at, int order) { return evaluate(at, order); }, u, p);
}

HermiteCurve HermiteCurve::with_nodes(std::vector<double> added) const {
  std::erase_if(added, [&](double u) { return !(u > start()) || !(u < end()); });
  std::sort(added.begin(), added.end());
  std::vector<double> u = {start()};
  std::vector<int> corners, old_node;  // old_node: of the new nodes, or -1
  auto next = added.begin();
  old_node.push_back(0);
  for (int i = 0; i < segment_count(); ++i) {
    for (; next != added.end() && *next < parameters()[i + 1]; ++next)
      if (*next > u.back()) {
        u.push_back(*next);
        old_node.push_back(-1);
      }
    u.push_back(parameters()[i + 1]);
    old_node.push_back(i + 1);
  }
  if (closed()) old_node.pop_back();
  for (size_t i = 0; i < old_node.size(); ++i)
    if (old_node[i] >= 0 && mesh_.is_corner(old_node[i])) corners.push_back(static_cast<int>(i));
  CurveMesh mesh(std::move(u), closed(), std::move(corners));
  Points dofs(mesh.dof_count(), 3);
  for (int i = 0; i < mesh.node_count(); ++i) {
    const int old = old_node[i];
    const double at = mesh.parameters()[i];
    dofs.row(mesh.position_dof(i)) = old < 0 ? evaluate(at) : position(old);
    dofs.row(mesh.slope_in(i)) = old < 0 ? evaluate(at, 1) : slope_in(old);
    dofs.row(mesh.slope_out(i)) = old < 0 ? evaluate(at, 1) : slope_out(old);
  }
  return {std::move(mesh), std::move(dofs)};
}

}  // namespace batten
