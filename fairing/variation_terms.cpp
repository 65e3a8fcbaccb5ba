#include "batten/fairing/variation_terms.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "batten/core/errors.h"
#include "batten/core/index.h"
#include "batten/core/parallel.h"
#include "batten/core/simd.h"
#include "batten/fairing/hct_tables.h"

namespace batten {
namespace {

using Dofs = Eigen::Matrix<double, 12, 3>;
using EdgeRow = Eigen::Matrix<double, kEdgeDofs, 1>;
using LocalJet = Eigen::Matrix<double, 3, 5>;  // X_1, X_2, X_11, X_12, X_22

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kPointWeight = 1.0 / 18;  // of nine points in a triangle of area ½
const Vec2 kCorner[3] = {{1, 0}, {0, 1}, {0, 0}};

Mat12 dof_map(const Surface& surface, int t) {
  return C1Triangle(TriangleElement::HCT, surface.mesh().shape(t)).to_reference_dofs();
}

Vec2 edge_way(int i) { return kCorner[(i + 2) % 3] - kCorner[(i + 1) % 3]; }

double cross(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }

// Weights of second derivatives in the second derivative along a direction.
Vec3 twice_along(const Vec2& d) { return {d.x() * d.x(), 2 * d.x() * d.y(), d.y() * d.y()}; }

// The jump of curvature across a line: r = weight · n·jump, where `jump` is that of the second
// derivative along `across`. The terms beside depend on n.
struct Jump {
  double weight, value;
  Vec3 n;
  Vec2 slopes;  // derivative of n·jump by X_a is slopes[a] · n
};
// `way`: the whole line; `thickness`: area of the elements beside it over that of the triangle,
// twice the mean; `across`: any direction beside it.
Jump jump_of(const Eigen::Matrix<double, 3, 2>& X, const Vec3& jump, const Vec2& way,
             const Vec2& across, double thickness, double jumps) {
  Jump j;
  const Vec3 area = X.col(0).cross(X.col(1));
  const double J = area.norm(), length = (X * way).norm();
  const double width = J * std::abs(cross(way, across)) / length;  // of one unit of `across`
  const double altitude = J * thickness / length;
  j.n = area / J;
  j.weight = std::sqrt(0.5 * jumps * length / altitude) / (width * width);
  j.value = j.weight * j.n.dot(jump);
  const Mat2 g = X.transpose() * X;
  j.slopes = -(g.inverse() * (X.transpose() * jump));
  return j;
}

// Spokes lie between thirds.
constexpr double kSpokeThickness = 1.0 / 3;

// Twist of the normal along an edge: II of the unit tangent and its perpendicular.
struct Twist {
  double tau, along_form;  // II_12, II_11
  Vec3 n, Y1, Y2;
  Mat2 M;
  Vec2 gamma;  // Γ^l_12
};
Twist twist_of(const LocalJet& jet, const Vec2& way) {
  Twist t;
  const Eigen::Matrix<double, 3, 2> X = jet.leftCols<2>();
  const Vec2 beside(-way.y(), way.x());
  const Vec3 along = X * way, other = X * beside;
  t.Y1 = along.normalized();
  const double b = other.dot(t.Y1);
  const Vec3 rest = other - b * t.Y1;
  t.Y2 = rest.normalized();
  t.M.row(0) = way.transpose() / along.norm();
  t.M.row(1) = (beside.transpose() - b * t.M.row(0)) / rest.norm();
  t.n = t.Y1.cross(t.Y2);
  const auto second = [&](int a, int c) -> Vec3 {
    return jet.col(2) * t.M(a, 0) * t.M(c, 0) +
           jet.col(3) * (t.M(a, 0) * t.M(c, 1) + t.M(a, 1) * t.M(c, 0)) +
           jet.col(4) * t.M(a, 1) * t.M(c, 1);
  };
  const Vec3 Y12 = second(0, 1);
  t.tau = t.n.dot(Y12);
  t.along_form = t.n.dot(second(0, 0));
  t.gamma = {t.Y1.dot(Y12), t.Y2.dot(Y12)};
  return t;
}

LocalJet local_jet(const Dofs& q, const HctTables::EdgePoint& point) {
  LocalJet jet;
  jet.leftCols<2>() = q.transpose().lazyProduct(point.slopes);
  jet.rightCols<3>() = q.transpose().lazyProduct(point.second);
  return jet;
}

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

}  // namespace

VariationTerms::VariationTerms(const Surface& start, double gauss, double jumps)
    : gauss_(gauss),
      jumps_(jumps),
      length_(std::sqrt(start.area())),
      frames_(9 * static_cast<size_t>(start.mesh().triangle_count())),
      twists_of_(start.mesh().triangle_count()) {
  const auto& edges = start.mesh().edges();
  for (int e = 0; e < count_of(edges); ++e)
    if (!edges[e].boundary()) edges_.push_back(e);
  set_frames(start);
}

void VariationTerms::set_frames(const Surface& surface) {
  const int count = surface.mesh().triangle_count();
  const auto& tables = HctTables::get();
  std::vector<double> split(frames_.size()), sums(count), areas(count);
  parallel_parts(count, [&](int t) {
    const Dofs q = dof_map(surface, t).lazyProduct(surface.triangle_dofs(t));
    for (int p = 0; p < 9; ++p) {
      const Jet3 jet = q.transpose().lazyProduct(tables.inside[p]);
      Frame& frame = frames_[9 * t + p];
      frame.M = principal_frame(jet);
      const CurvatureForms forms = curvature_forms(jet, frame.M);
      split[9 * t + p] = 0.5 * (forms.II[0] - forms.II[2]);
      const double dA = share(surface, t) * forms.jacobian;
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
    const Dofs q = dof_map(start, t).lazyProduct(start.triangle_dofs(t));
    for (size_t k = 0; k < 3; ++k) {
      const LocalJet jet = local_jet(q, tables.edges3[local][k]);
      const Vec3 d1 = jet.leftCols<2>() * way, d2 = jet.rightCols<3>() * twice_along(way);
      const double ds = HctTables::weight3[k] * d1.norm();
      samples.push_back({ds, d1.cross(d2) / std::pow(d1.norm(), 3)});
      length += ds;
      turn += ds * twist_of(jet, way).tau;
    }
  }
  // Edges of one side may run against each other in their triangles: curvatures then differ in sign
  // only by that of d1 × d2, which is that of the boundary's direction, the same for all.
  Vec3 mean = Vec3::Zero();
  for (const Sample& s : samples) mean += s.ds / length * s.curvature;
  double spread = 0;
  for (const Sample& s : samples) spread += s.ds / length * (s.curvature - mean).squaredNorm();
  const double uneven = length * std::sqrt(spread) / (1 + length * mean.norm());
  turn = std::remainder(turn, 2 * std::numbers::pi);
  const double gate = (1 + std::pow(turn / 0.05, 2)) * (1 + std::pow(uneven / 0.1, 2));
  for (const int e : edges)
    twists_of_[mesh.edges()[e].triangle[0]].push_back(
        {mesh.edges()[e].local[0], 3 / (length_ * gate)});
}

ChangeWeights VariationTerms::weights_at(int triangle, int point) const {
  return {frames_[9 * triangle + point].principal, 1e-4 / (length_ * length_), gauss_};
}

double VariationTerms::share(const Surface& surface, int t) {
  constexpr double outside = 1e-6;  // keeps the matrix definite
  return surface.trim() ? std::max(outside, surface.trim()->share(t)) : 1;
}

double VariationTerms::share_beside(const Surface& surface, int e) {
  const auto& edge = surface.mesh().edges()[e];
  return 0.5 * (share(surface, edge.triangle[0]) + share(surface, edge.triangle[1]));
}

double VariationTerms::value(const Surface& surface) const {
  const int triangles = surface.mesh().triangle_count(), count = triangles + count_of(edges_);
  std::vector<double> parts(count);
  parallel_parts(count, [&](int i) {
    parts[i] =
        i < triangles ? triangle_value(surface, i) : edge_value(surface, edges_[i - triangles]);
  });
  double sum = 0;
  for (const double part : parts) sum += part;
  return std::isfinite(sum) ? sum : kInfinity;
}

double VariationTerms::triangle_value(const Surface& surface, int t) const {
  const auto& tables = HctTables::get();
  const Dofs q = dof_map(surface, t).lazyProduct(surface.triangle_dofs(t));
  double sum = 0;
  for (int p = 0; p < 9; ++p) {
    const Jet3 jet = q.transpose().lazyProduct(tables.inside[p]);
    sum += kPointWeight *
           change_residuals(curvature_forms(jet, frames_[9 * t + p].M), weights_at(t, p))
               .squaredNorm();
  }
  for (int i = 0; i < 3; ++i)
    for (const auto& point : tables.spokes[i]) {
      const Vec2 way = Vec2(1.0 / 3, 1.0 / 3) - kCorner[i], across = edge_way(i);
      const Vec3 jump = q.transpose() * (point.jump * twice_along(across));
      const double r = jump_of(q.transpose().lazyProduct(point.slopes), jump, way, across,
                               kSpokeThickness, jumps_)
                           .value;
      sum += r * r;
    }
  for (const TwistEdge& side : twists_of_[t])
    for (size_t k = 0; k < 3; ++k) {
      const LocalJet jet = local_jet(q, tables.edges3[side.local][k]);
      const Vec2 way = edge_way(side.local);
      const double ds = HctTables::weight3[k] * (jet.leftCols<2>() * way).norm();
      const double tau = twist_of(jet, way).tau;
      sum += side.weight * ds * tau * tau;
    }
  return share(surface, t) * sum;
}

TriangleTerms VariationTerms::triangle(const Surface& surface, int t,
                                       const StepWeights& step) const {
  const auto& tables = HctTables::get();
  const Mat12 P = dof_map(surface, t);
  const Dofs q = P.lazyProduct(surface.triangle_dofs(t));
  Rows rows;
  const auto add = [&](double r, const Vec3& n, const Vec12& along, const Vec3& m,
                       const Vec12& beside) {
    for (int c = 0; c < 3; ++c)
      for (int a = 0; a < 12; ++a)
        rows.J[rows.count][12 * c + a] = n[c] * along[a] + m[c] * beside[a];
    rows.r[rows.count++] = r;
  };
  TriangleTerms terms;
  terms.normal.setZero();
  Mat12 change = Mat12::Zero();
  for (int p = 0; p < 9; ++p) {
    const Table3& N = tables.inside[p];
    const Jet3 jet = q.transpose().lazyProduct(N);
    const Mat2& M = frames_[9 * t + p].M;
    const ChangeWeights weights = weights_at(t, p);
    const double root = std::sqrt(kPointWeight);
    const CurvatureForms forms = curvature_forms(jet, M);
    const ChangeVector r = change_residuals(forms, weights);
    const ChangeJacobian by_jet = change_jacobian(jet, M, weights);
    for (int i = 0; i < kChangeResiduals; ++i) {
      double* row = rows.J[rows.count];
      for (int c = 0; c < 3; ++c)
        Eigen::Map<Vec12>(row + 12 * c) =
            root * N.lazyProduct(by_jet.row(i).segment<9>(9 * c).transpose());
      rows.r[rows.count++] = root * r[i];
    }

    // Second derivatives along the frame, in small steps.
    const Vec3 n = jet.col(0).cross(jet.col(1)).normalized();
    const double weight = kPointWeight * forms.jacobian / (length_ * length_);
    Mat12 one = Mat12::Zero();
    for (int a = 0; a < 2; ++a)
      for (int b = a; b < 2; ++b) {
        const Vec12 along = M(a, 0) * M(b, 0) * N.col(2) +
                            (M(a, 0) * M(b, 1) + M(a, 1) * M(b, 0)) * N.col(3) +
                            M(a, 1) * M(b, 1) * N.col(4);
        one += ((a == b ? weight : 2 * weight) * along).lazyProduct(along.transpose());
      }
    change += one;
    for (int c = 0; c < 3; ++c)
      for (int d = 0; d < 3; ++d)
        terms.normal.block<12, 12>(12 * c, 12 * d) -= step.evenness * n[c] * n[d] * one;
  }
  for (int c = 0; c < 3; ++c)
    terms.normal.block<12, 12>(12 * c, 12 * c) += (step.evenness + step.damping) * change;
  for (int i = 0; i < 3; ++i)
    for (const auto& point : tables.spokes[i]) {
      const Vec2 way = Vec2(1.0 / 3, 1.0 / 3) - kCorner[i], across = edge_way(i);
      const Vec12 jump = point.jump * twice_along(across);
      const Jump j = jump_of(q.transpose().lazyProduct(point.slopes), q.transpose() * jump, way,
                             across, kSpokeThickness, jumps_);
      add(j.value, j.weight * j.n, jump + point.slopes * j.slopes, Vec3::Zero(), Vec12::Zero());
    }
  for (const TwistEdge& side : twists_of_[t])
    for (size_t k = 0; k < 3; ++k) {
      const auto& point = tables.edges3[side.local][k];
      const Vec2 way = edge_way(side.local);
      const LocalJet jet = local_jet(q, point);
      const double ds = HctTables::weight3[k] * (jet.leftCols<2>() * way).norm();
      const double root = std::sqrt(side.weight * ds);
      const Twist w = twist_of(jet, way);
      const Vec12 Y12 =
          point.second * Vec3(w.M(0, 0) * w.M(1, 0), w.M(0, 0) * w.M(1, 1) + w.M(0, 1) * w.M(1, 0),
                              w.M(0, 1) * w.M(1, 1));
      const Vec12 Y2 = point.slopes * w.M.row(1).transpose();
      add(root * w.tau, root * w.n, Y12 - point.slopes * (w.M.transpose() * w.gamma),
          -root * (w.along_form * w.Y1 + w.tau * w.Y2), Y2);
    }
  add_squares(rows, terms.normal.data());
  const Eigen::Map<const Eigen::Matrix<double, kTriangleUnknowns, Eigen::Dynamic>> J(
      rows.J[0], kTriangleUnknowns, rows.count);
  const Eigen::Map<const VecX> r(rows.r, rows.count);
  const double part = share(surface, t);
  terms.value = part * r.squaredNorm();
  const Eigen::Matrix<double, kTriangleUnknowns, 1> gradient = part * (J * r);
  for (int c = 0; c < 3; ++c) {
    terms.gradient.segment<12>(12 * c) = P.transpose().lazyProduct(gradient.segment<12>(12 * c));
    for (int d = 0; d < 3; ++d) {
      const Mat12 half = part * terms.normal.block<12, 12>(12 * c, 12 * d).lazyProduct(P);
      terms.normal.block<12, 12>(12 * c, 12 * d) = P.transpose().lazyProduct(half);
    }
  }
  return terms;
}

namespace {

// Both sides of an interior edge.
class EdgePair {
 public:
  EdgePair(const Surface& surface, int e) {
    const ParametricMesh& mesh = surface.mesh();
    const auto& edge = mesh.edges()[e];
    const auto dofs = surface.dof_map().triangle(mesh, edge.triangle[0]),
               others = surface.dof_map().triangle(mesh, edge.triangle[1]);
    int next = 12;
    for (size_t a = 0; a < 12; ++a) {
      const auto it = std::find(dofs.begin(), dofs.end(), others[a]);
      slot_[a] = it == dofs.end() ? next++ : static_cast<int>(it - dofs.begin());
    }
    const Dofs other = surface.triangle_dofs(edge.triangle[1]);
    for (int a = 0; a < 12; ++a) q.row(slot_[static_cast<size_t>(a)]) = other.row(a);
    q.topRows<12>() = surface.triangle_dofs(edge.triangle[0]);

    Vec2 beside = Vec2::Zero();  // the same direction in (u, v) on both sides
    double area[2];
    for (int side = 0; side < 2; ++side) {
      const TriangleShape shape = mesh.shape(edge.triangle[side]);
      const auto& v = shape.vertex;
      local_[side] = edge.local[side];
      if (side == 0) {
        const Vec2 along = v[(local_[0] + 2) % 3] - v[(local_[0] + 1) % 3];
        beside = Vec2(-along.y(), along.x());
      }
      Mat2 A;
      A << v[0] - v[2], v[1] - v[2];
      across_[side] = A.inverse() * beside;
      P_[side] = C1Triangle(TriangleElement::HCT, shape).to_reference_dofs();
      area[side] = shape.area;
    }
    thickness_ = (1 + area[1] / area[0]) / 6;
  }

  Eigen::Matrix<double, kEdgeDofs, 3> q;

  // Second derivative across the edge at Gauss point k, first side less second, over the dofs of
  // both.
  EdgeRow jump(size_t k) const {
    const auto& tables = HctTables::get();
    EdgeRow all = EdgeRow::Zero();
    for (size_t side = 0; side < 2; ++side) {
      // The edges run against each other.
      const auto& point = tables.edges[local_[side]][side == 0 ? k : 1 - k];
      const Vec12 reference = point.second * twice_along(across_[side]);
      const Vec12 own = P_[side].transpose().lazyProduct(reference);
      if (side == 0)
        all.head<12>() += own;
      else
        for (size_t a = 0; a < 12; ++a) all[slot_[a]] -= own[static_cast<long>(a)];
    }
    return all;
  }
  HctTables::Slopes slopes(size_t k) const {
    return P_[0].transpose().lazyProduct(HctTables::get().edges[local_[0]][k].slopes);
  }
  Jump at(const HctTables::Slopes& slopes, const EdgeRow& jump, double jumps) const {
    return jump_of(q.topRows<12>().transpose().lazyProduct(slopes), q.transpose() * jump,
                   edge_way(local_[0]), across_[0], thickness_, jumps);
  }

 private:
  std::array<int, 12> slot_;  // of the second side's dofs
  Mat12 P_[2];
  Vec2 across_[2];
  int local_[2];
  double thickness_;
};

}  // namespace

std::array<int, kEdgeDofs> VariationTerms::edge_dofs(const Surface& surface, int e) {
  std::array<int, kEdgeDofs> dofs;
  const auto& edge = surface.mesh().edges()[e];
  const auto first = surface.dof_map().triangle(surface.mesh(), edge.triangle[0]),
             second = surface.dof_map().triangle(surface.mesh(), edge.triangle[1]);
  auto end = std::copy(first.begin(), first.end(), dofs.begin());
  for (const int dof : second)
    if (std::find(first.begin(), first.end(), dof) == first.end()) *end++ = dof;
  return dofs;
}

double VariationTerms::edge_value(const Surface& surface, int e) const {
  const EdgePair pair(surface, e);
  double sum = 0;
  for (size_t k = 0; k < 2; ++k)
    sum += std::pow(pair.at(pair.slopes(k), pair.jump(k), jumps_).value, 2);
  return share_beside(surface, e) * sum;
}

EdgeTerms VariationTerms::edge(const Surface& surface, int e) const {
  const EdgePair pair(surface, e);
  Eigen::Matrix<double, 2, kEdgeUnknowns> rows;
  Vec2 r;
  for (int k = 0; k < 2; ++k) {
    const HctTables::Slopes slopes = pair.slopes(static_cast<size_t>(k));
    EdgeRow row = pair.jump(static_cast<size_t>(k));
    const Jump j = pair.at(slopes, row, jumps_);
    row.head<12>() += slopes * j.slopes;
    r[k] = j.value;
    for (int c = 0; c < 3; ++c)
      rows.block<1, kEdgeDofs>(k, kEdgeDofs * c) = j.weight * j.n[c] * row.transpose();
  }
  const double part = share_beside(surface, e);
  EdgeTerms terms;
  terms.normal = part * rows.transpose().lazyProduct(rows);
  terms.gradient = part * rows.transpose().lazyProduct(r);
  terms.value = part * r.squaredNorm();
  return terms;
}

}  // namespace batten
