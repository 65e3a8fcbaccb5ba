#include <Eigen/Geometry>
#include <cmath>

#include "batten/core/simd.h"
#include "batten/fairing/variation_geometry.h"
#include "batten/fairing/variation_terms.h"

namespace batten {
namespace {

// Rows of J over the reference dofs, one after the other.
struct Rows {
  static constexpr int most = 9 * kChangeResiduals + 6 + 9;
  alignas(64) double J[most][kTriangleUnknowns];
  double r[most];
  int count = 0;
};

// K += JᵀJ, both triangles of K.
BATTEN_CLONES void add_squares(const Rows& rows, double* K) {
  typedef double Lanes __attribute__((vector_size(32), aligned(8)));
  constexpr int n = kTriangleUnknowns, lanes = 4, parts = n / lanes;
  for (int j = 0; j < n; ++j) {
    Lanes sum[parts] = {};
    for (int r = 0; r < rows.count; ++r) {
      const double factor = rows.J[r][j];
      const Lanes* row = reinterpret_cast<const Lanes*>(rows.J[r]);
      for (int p = 0; p < parts; ++p) sum[p] += factor * row[p];
    }
    for (int p = 0; p < parts; ++p)
      for (int k = 0; k < lanes; ++k) K[n * j + lanes * p + k] += sum[p][k];
  }
}

// Gathers the residuals of one triangle, with their derivatives by the reference dofs.
class TriangleRows {
 public:
  TriangleRows(const TriangleDofs& q, TriangleTerms& terms) : q_(q), terms_(terms) {
    terms_.normal.setZero();
  }

  // The change of curvature at one of the nine points, and the weights that keep steps small.
  void add_change(const Table3& N, const Mat2& frame, const ChangeWeights& weights,
                  const StepWeights& step, double size) {
    const Jet3 jet = q_.transpose().lazyProduct(N);
    const CurvatureForms forms = curvature_forms(jet, frame);
    const ChangeVector r = change_residuals(forms, weights);
    const ChangeJacobian by_jet = change_jacobian(jet, frame, weights);
    const double root = std::sqrt(kPointWeight);
    for (int i = 0; i < kChangeResiduals; ++i) {
      double* row = rows_.J[rows_.count];
      for (int c = 0; c < 3; ++c)
        Eigen::Map<Vec12>(row + 12 * c) =
            root * N.lazyProduct(by_jet.row(i).segment<9>(9 * c).transpose());
      rows_.r[rows_.count++] = root * r[i];
    }
    const Vec3 n = jet.col(0).cross(jet.col(1)).normalized();
    const Mat12 change = kPointWeight * forms.jacobian / (size * size) * second_squares(N, frame);
    change_ += change;
    for (int c = 0; c < 3; ++c)
      for (int d = 0; d < 3; ++d)
        terms_.normal.block<12, 12>(12 * c, 12 * d) -= step.evenness * n[c] * n[d] * change;
  }

  void add_spoke(int i, const HctTables::Spoke& point, double jumps) {
    const Vec2 across = edge_way(i);
    const Vec12 jump = point.jump * twice_along(across);
    const CurvatureJump j = jump_of(q_.transpose().lazyProduct(point.slopes), q_.transpose() * jump,
                                    spoke_way(i), across, kSpokeThickness, jumps);
    add(j.value, j.weight * j.n, jump + point.slopes * j.slopes, Vec3::Zero(), Vec12::Zero());
  }

  void add_twist(int i, const HctTables::EdgePoint& point, double weight) {
    const LocalJet jet = local_jet(q_, point);
    const double root = std::sqrt(weight * (jet.leftCols<2>() * edge_way(i)).norm());
    const EdgeTwist w = twist_of(jet, edge_way(i));
    const Vec3 mixed(w.M(0, 0) * w.M(1, 0), w.M(0, 0) * w.M(1, 1) + w.M(0, 1) * w.M(1, 0),
                     w.M(0, 1) * w.M(1, 1));
    const Vec12 Y12 = point.second * mixed, Y2 = point.slopes * w.M.row(1).transpose();
    add(root * w.tau, root * w.n, Y12 - point.slopes * (w.M.transpose() * w.gamma),
        -root * (w.along_form * w.Y1 + w.tau * w.Y2), Y2);
  }

  // Squares the rows, times `share`, over the triangle's own dofs: P takes these to q.
  void finish(const Mat12& P, const StepWeights& step, double share) {
    for (int c = 0; c < 3; ++c)
      terms_.normal.block<12, 12>(12 * c, 12 * c) += (step.evenness + step.damping) * change_;
    add_squares(rows_, terms_.normal.data());
    const Eigen::Map<const Eigen::Matrix<double, kTriangleUnknowns, Eigen::Dynamic>> J(
        rows_.J[0], kTriangleUnknowns, rows_.count);
    const Eigen::Map<const VecX> r(rows_.r, rows_.count);
    terms_.value = share * r.squaredNorm();
    const Eigen::Matrix<double, kTriangleUnknowns, 1> gradient = share * (J * r);
    for (int c = 0; c < 3; ++c) {
      terms_.gradient.segment<12>(12 * c) = P.transpose().lazyProduct(gradient.segment<12>(12 * c));
      for (int d = 0; d < 3; ++d) {
        auto block = terms_.normal.block<12, 12>(12 * c, 12 * d);
        const Mat12 half = share * block.lazyProduct(P);
        block = P.transpose().lazyProduct(half);
      }
    }
  }

 private:
  // A row n_c along_a + m_c beside_a.
  void add(double r, const Vec3& n, const Vec12& along, const Vec3& m, const Vec12& beside) {
    for (int c = 0; c < 3; ++c)
      for (int a = 0; a < 12; ++a)
        rows_.J[rows_.count][12 * c + a] = n[c] * along[a] + m[c] * beside[a];
    rows_.r[rows_.count++] = r;
  }

  // N_11 N_11ᵀ + 2 N_12 N_12ᵀ + N_22 N_22ᵀ, derivatives along the frame.
  static Mat12 second_squares(const Table3& N, const Mat2& M) {
    Mat12 sum = Mat12::Zero();
    for (int a = 0; a < 2; ++a)
      for (int b = a; b < 2; ++b) {
        const Vec12 along = M(a, 0) * M(b, 0) * N.col(2) +
                            (M(a, 0) * M(b, 1) + M(a, 1) * M(b, 0)) * N.col(3) +
                            M(a, 1) * M(b, 1) * N.col(4);
        sum += ((a == b ? 1 : 2) * along).lazyProduct(along.transpose());
      }
    return sum;
  }

  const TriangleDofs& q_;
  TriangleTerms& terms_;
  Rows rows_;
  Mat12 change_ = Mat12::Zero();
};

}  // namespace

TriangleTerms VariationTerms::triangle(const Surface& surface, int t,
                                       const StepWeights& step) const {
  const auto& tables = HctTables::get();
  const Mat12 P = reference_map(surface, t);
  const TriangleDofs q = P.lazyProduct(surface.triangle_dofs(t));
  TriangleTerms terms;
  TriangleRows rows(q, terms);
  for (int p = 0; p < 9; ++p)
    rows.add_change(tables.inside[p], frames_[9 * t + p].M, weights_at(t, p), step, length_);
  for (int i = 0; i < 3; ++i)
    for (const auto& point : tables.spokes[i]) rows.add_spoke(i, point, jumps_);
  for (int i = 0; i < 3; ++i)
    if (const double weight = twists_[t][i]; weight > 0)
      for (size_t k = 0; k < 3; ++k)
        rows.add_twist(i, tables.edges3[i][k], weight * HctTables::weight3[k]);
  rows.finish(P, step, share(surface, t));
  return terms;
}

}  // namespace batten
