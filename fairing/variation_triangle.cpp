#include <Eigen/Geometry>
#include <cmath>

#include "batten/fairing/variation_geometry.h"
#include "batten/fairing/variation_terms.h"

namespace batten {
namespace {

// Writes the residuals of one triangle, with their derivatives by the reference dofs, then by the
// triangle's own.
class ResidualWriter {
 public:
  ResidualWriter(const TriangleDofs& q, double weight, TriangleResiduals& rows)
      : q_(q), root_(std::sqrt(weight)), rows_(rows) {}

  // The change of curvature at one of the nine points, and the rows that keep steps small.
  void add_change(const Table3& N, const Mat2& frame, const CurvatureVariationWeights& weights,
                  const DampingWeights& step, double size) {
    const Jet3 jet = q_.transpose().lazyProduct(N);
    CurvatureVariationVector r;
    const CurvatureVariationJacobian by_jet = curvature_variation_jacobian(jet, frame, weights, r);
    const double root = root_ * std::sqrt(kPointWeight);
    for (int c = 0; c < 3; ++c)
      for (int a = 0; a < 12; ++a) {
        CurvatureVariationVector column = CurvatureVariationVector::Zero();
        for (int k = 0; k < 9; ++k) column += N(a, k) * by_jet.col(9 * c + k);
        Eigen::Map<CurvatureVariationVector>(rows_.J[12 * c + a] + rows_.count) = root * column;
      }
    Eigen::Map<CurvatureVariationVector>(rows_.r + rows_.count) = root * r;
    rows_.count += kCurvatureVariationResiduals;

    const Vec3 area = jet.col(0).cross(jet.col(1));
    // Steps are held outside of a trim as inside: the matrix stays definite there.
    const double J = area.norm(), per_size = std::sqrt(kPointWeight * J) / size;
    const Vec3 n = area / J, t = (jet.leftCols<2>() * frame.row(0).transpose()).normalized();
    if (step.normal > 0) add_second(N, frame, std::sqrt(step.normal) * per_size * n);
    if (step.tangential > 0) {
      add_second(N, frame, std::sqrt(step.tangential) * per_size * t);
      add_second(N, frame, std::sqrt(step.tangential) * per_size * n.cross(t));
    }
  }

  void add_spoke(int i, const HctTables::Spoke& point, double jumps) {
    const Vec2 across = edge_direction(i);
    const Vec12 jump = point.jump * second_derivative_weights(across);
    const CurvatureJump j =
        curvature_jump(q_.transpose().lazyProduct(point.slopes), q_.transpose() * jump,
                       spoke_direction(i), across, kSpokeThickness, jumps);
    add(root_ * j.value, root_ * j.weight * j.n, jump + point.slopes * j.slopes);
  }

  void add_twist(int i, const HctTables::EdgePoint& point, double weight) {
    const LocalJet jet = local_jet(q_, point);
    const double root = root_ * std::sqrt(weight * (jet.leftCols<2>() * edge_direction(i)).norm());
    const EdgeSecondForm w = edge_second_form(jet, edge_direction(i));
    const Vec12 Y12 = point.second * mixed_derivative_weights(w.M, 0, 1),
                Y2 = point.slopes * w.M.row(1).transpose();
    add(root * w.twist, root * w.n, Y12 - point.slopes * (w.M.transpose() * w.gamma12),
        -root * (w.along * w.Y1 + w.twist * w.Y2), Y2);
  }

  // By the triangle's own dofs: P takes these to q.
  void finish(const Mat12& P) {
    const int count = rows_.count;
    alignas(64) double own[12][TriangleResiduals::most];
    for (int c = 0; c < 3; ++c) {
      for (int a = 0; a < 12; ++a) {
        std::fill_n(own[a], count, 0.0);
        for (int b = 0; b < 12; ++b)
          if (const double factor = P(b, a); factor != 0)
            for (int r = 0; r < count; ++r) own[a][r] += factor * rows_.J[12 * c + b][r];
      }
      for (int a = 0; a < 12; ++a) std::copy_n(own[a], count, rows_.J[12 * c + a]);
    }
  }

 private:
  // A row n_c along_a + m_c beside_a.
  void add(double r, const Vec3& n, const Vec12& along, const Vec3& m = Vec3::Zero(),
           const Vec12& beside = Vec12::Zero()) {
    for (int c = 0; c < 3; ++c)
      for (int a = 0; a < 12; ++a)
        rows_.J[12 * c + a][rows_.count] = n[c] * along[a] + m[c] * beside[a];
    rows_.r[rows_.count++] = r;
  }

  // Second derivatives along the frame, in direction w: w·X_11, √2 w·X_12, w·X_22.
  void add_second(const Table3& N, const Mat2& M, const Vec3& w) {
    for (int a = 0; a < 2; ++a)
      for (int b = a; b < 2; ++b) {
        const Vec12 along = N.middleCols<3>(2) * mixed_derivative_weights(M, a, b);
        add(0, a == b ? w : Vec3(std::sqrt(2.0) * w), along);
      }
  }

  const TriangleDofs& q_;
  double root_;
  TriangleResiduals& rows_;
};

}  // namespace

void CurvatureVariationTerms::triangle(const Surface& surface, int t, const DampingWeights& step,
                                       TriangleResiduals& rows) const {
  rows.count = 0;
  if (weights_[t] == 0) return;
  const auto& tables = HctTables::get();
  const Mat12 P = reference_map(surface, t);
  const TriangleDofs q = P.lazyProduct(surface.triangle_dofs(t));
  ResidualWriter writer(q, weights_[t], rows);
  for (int p = 0; p < 9; ++p)
    writer.add_change(tables.inside[p], frames_[9 * t + p].M, weights_at(t, p), step, length_);
  for (int i = 0; i < 3; ++i)
    for (const auto& point : tables.spokes[i]) writer.add_spoke(i, point, jumps_);
  for (int i = 0; i < 3; ++i)
    if (const double weight = twists_[t][i]; weight > 0)
      for (size_t k = 0; k < 3; ++k)
        writer.add_twist(i, tables.edges3[i][k], weight * HctTables::weight3[k]);
  writer.finish(P);
}

}  // namespace batten
