// SPDX-License-Identifier: MPL-2.0
#include "batten/fairing/minimum_variation/curvature_variation_terms.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/parallel.h"
#include "batten/fairing/minimum_variation/variation_geometry.h"

namespace batten {

CurvatureVariationTerms::CurvatureVariationTerms(const Surface& start, double gauss, double jumps,
                                                 const std::vector<char>& frozen)
    : gauss_(gauss),
      jumps_(jumps),
      length_(std::sqrt(start.area())),
      weights_(start.mesh().triangle_count(), 1),
      frames_(9 * static_cast<size_t>(start.mesh().triangle_count())),
      twists_(start.mesh().triangle_count(), Vec3::Zero()) {
  constexpr double outside = 1e-6;  // weight outside of a trim; keeps the matrix definite
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
    throw InputError("the surface to be faired is singular: it has no normal at some point");
  // Principal curvatures that differ by less than a hundredth of the mean curvature count as equal.
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
    if (e < 0) throw InputError("a side of the outline is not a chain of mesh edges");
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

namespace {

// Writes the residuals of one triangle, with their derivatives by the reference dofs, then by the
// triangle's own dofs.
class ResidualWriter {
 public:
  ResidualWriter(const TriangleDofs& q, double weight, TriangleResiduals& rows)
      : q_(q), root_(std::sqrt(weight)), rows_(rows) {}

  // The curvature variation at one of the nine points, and the damping rows.
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
    // Damping acts outside of a trim as inside: the matrix stays definite there.
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

  // Transforms the derivatives to the triangle's own dofs, from which P gives q.
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
  // Adds a row n_c along_a + m_c beside_a.
  void add(double r, const Vec3& n, const Vec12& along, const Vec3& m = Vec3::Zero(),
           const Vec12& beside = Vec12::Zero()) {
    for (int c = 0; c < 3; ++c)
      for (int a = 0; a < 12; ++a)
        rows_.J[12 * c + a][rows_.count] = n[c] * along[a] + m[c] * beside[a];
    rows_.r[rows_.count++] = r;
  }

  // Adds rows for the second derivatives along the frame in direction w: w·X_11, √2 w·X_12, w·X_22.
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

namespace {

using EdgeRow = Eigen::Matrix<double, kEdgeDofs, 1>;

// Dofs and geometry of both sides of an interior edge.
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
    const TriangleDofs other = surface.triangle_dofs(edge.triangle[1]);
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
      P_[side] = reference_map(surface, edge.triangle[side]);
      area[side] = shape.area;
    }
    thickness_ = (1 + area[1] / area[0]) / 6;
  }

  Eigen::Matrix<double, kEdgeDofs, 3> q;

  // Jump of the second derivative across the edge at Gauss point k, first side minus second, over
  // the dofs of both.
  EdgeRow jump(size_t k) const {
    const auto& tables = HctTables::get();
    EdgeRow all = EdgeRow::Zero();
    for (size_t side = 0; side < 2; ++side) {
      // The edge has opposite directions on its two sides.
      const auto& point = tables.edges[local_[side]][side == 0 ? k : 1 - k];
      const Vec12 reference = point.second * second_derivative_weights(across_[side]);
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
  CurvatureJump at(const HctTables::Slopes& slopes, const EdgeRow& jump, double jumps) const {
    return curvature_jump(q.topRows<12>().transpose().lazyProduct(slopes), q.transpose() * jump,
                          edge_direction(local_[0]), across_[0], thickness_, jumps);
  }

 private:
  std::array<int, 12> slot_;  // index of each dof of the second side
  Mat12 P_[2];
  Vec2 across_[2];
  int local_[2];
  double thickness_;
};

}  // namespace

std::array<int, kEdgeDofs> CurvatureVariationTerms::edge_dofs(const Surface& surface, int e) {
  std::array<int, kEdgeDofs> dofs;
  const auto& edge = surface.mesh().edges()[e];
  const auto first = surface.dof_map().triangle(surface.mesh(), edge.triangle[0]),
             second = surface.dof_map().triangle(surface.mesh(), edge.triangle[1]);
  auto end = std::copy(first.begin(), first.end(), dofs.begin());
  for (const int dof : second)
    if (std::find(first.begin(), first.end(), dof) == first.end()) *end++ = dof;
  return dofs;
}

double CurvatureVariationTerms::edge_value(const Surface& surface, int e) const {
  const EdgePair pair(surface, e);
  double sum = 0;
  for (size_t k = 0; k < 2; ++k)
    sum += std::pow(pair.at(pair.slopes(k), pair.jump(k), jumps_).value, 2);
  return edge_weight(surface, e) * sum;
}

void CurvatureVariationTerms::edge(const Surface& surface, int e, EdgeResiduals& rows) const {
  const EdgePair pair(surface, e);
  const double root = std::sqrt(edge_weight(surface, e));
  rows.count = 2;
  for (int k = 0; k < 2; ++k) {
    const HctTables::Slopes slopes = pair.slopes(static_cast<size_t>(k));
    EdgeRow row = pair.jump(static_cast<size_t>(k));
    const CurvatureJump j = pair.at(slopes, row, jumps_);
    row.head<12>() += slopes * j.slopes;
    rows.r[k] = root * j.value;
    for (int c = 0; c < 3; ++c)
      for (int a = 0; a < kEdgeDofs; ++a)
        rows.J[kEdgeDofs * c + a][k] = root * j.weight * j.n[c] * row[a];
  }
}

namespace {

// Second fundamental forms on both sides of a join point, and the weighted jumps of curvature and
// of the tangent plane.
template <class Point>
struct Sides {
  EdgeSecondForm forms[2];
  double root, jump;    // weight (square root) and jump of the curvature
  double stiff, angle;  // weight (square root) and jump angle of the tangent plane

  Sides(const Point& point, const TriangleDofs* q, const std::array<double, 2>& areas,
        double jumps) {
    double thickness = 0, speed = 0;
    for (int s = 0; s < 2; ++s) {
      const auto side = static_cast<size_t>(s);
      const LocalJet jet = q[s].transpose().lazyProduct(point.N[side]);
      forms[s] = edge_second_form(jet, point.direction[side]);
      // Altitude of the third beside the line, relative to √area, for an equilateral triangle.
      constexpr double altitude = 0.439;
      thickness += altitude / 2 * std::sqrt(areas[side] * jet.col(0).cross(jet.col(1)).norm());
      speed += 0.5 * (jet.leftCols<2>() * point.direction[side]).norm();
    }
    // The other side of a given surface does not move.
    constexpr double given = 10;
    root = std::sqrt((point.given ? given : 1) * jumps * point.weight * speed / thickness);
    const Vec3& n = forms[0].n;
    jump = forms[0].across -
           (point.given ? n.dot(point.given->curvature) : point.sign * forms[1].across);
    constexpr double first = 10;  // the tangent plane has priority over the curvature
    stiff = first * root / thickness;
    angle = n.dot(point.given ? point.given->into : forms[1].Y2);
    if (!point.curvature) root = 0;
    if (!point.tangent) stiff = 0;
  }
};

std::array<double, 2> areas_of(const Surface& surface, const std::array<int, 2>& triangle) {
  return {surface.mesh().shape(triangle[0]).area, surface.mesh().shape(triangle[1]).area};
}

}  // namespace

void CurvatureVariationTerms::add_joins(const Surface& start,
                                        const std::vector<JoinPoint>& points) {
  for (const JoinPoint& point : points) {
    Join& added = joins_.emplace_back();
    added.direction = point.direction;
    added.weight = point.weight;
    added.curvature = point.curvature;
    added.tangent = point.tangent;
    added.given = point.given;
    Vec3 normal[2];
    for (size_t s = 0; s < 2; ++s) {
      const Location& at = point.at[s];
      added.triangle[s] = at.triangle;
      const Tabulation N = C1Triangle(start.kind(), start.mesh().shape(at.triangle)).evaluate(at.L);
      added.N[s] = N.middleCols<5>(kU);
      normal[s] = start.jet(at).normal();
    }
    added.sign = normal[0].dot(normal[1]) < 0 ? -1 : 1;
  }
}

std::array<int, kJoinDofs> CurvatureVariationTerms::join_dofs(const Surface& surface, int j) const {
  std::array<int, kJoinDofs> dofs;
  auto next = dofs.begin();
  for (const int t : joins_[j].triangle) {
    const auto own = surface.dof_map().triangle(surface.mesh(), t);
    next = std::copy(own.begin(), own.end(), next);
  }
  return dofs;
}

double CurvatureVariationTerms::join_value(const Surface& surface, const Join& join) const {
  const TriangleDofs q[2] = {surface.triangle_dofs(join.triangle[0]),
                             surface.triangle_dofs(join.triangle[1])};
  const Sides sides(join, q, areas_of(surface, join.triangle), jumps_);
  return std::pow(sides.root * sides.jump, 2) + std::pow(sides.stiff * sides.angle, 2);
}

void CurvatureVariationTerms::join(const Surface& surface, int j, JoinResiduals& rows) const {
  const Join& join = joins_[j];
  const TriangleDofs q[2] = {surface.triangle_dofs(join.triangle[0]),
                             surface.triangle_dofs(join.triangle[1])};
  const Sides sides(join, q, areas_of(surface, join.triangle), jumps_);
  const Vec3& other = join.given ? join.given->into : sides.forms[1].Y2;
  for (int s = 0; s < 2; ++s) {
    if (s == 1 && join.given) {
      for (int c = 0; c < 3; ++c)
        for (int a = 0; a < 12; ++a)
          for (int row = 0; row < 2; ++row) rows.J[kJoinDofs * c + 12 + a][row] = 0;
      break;
    }
    const EdgeSecondForm& f = sides.forms[s];
    const auto& N = join.N[static_cast<size_t>(s)];
    const double root = sides.root * (s == 0 ? 1 : -join.sign);
    // The normal on the second side changes relative to the first one, or vice versa.
    const double tilt = s == 1 ? sides.stiff : -sides.stiff * other.dot(f.Y2);
    const Vec3 turn = -2 * (f.twist * f.Y1 + f.across * f.Y2);
    const Vec3& n = sides.forms[0].n;
    const Vec12 Y2 = N.leftCols<2>() * f.M.row(1).transpose();
    const Vec12 Y22 = N.rightCols<3>() * mixed_derivative_weights(f.M, 1, 1) -
                      N.leftCols<2>() * (f.M.transpose() * f.gamma22);
    for (int c = 0; c < 3; ++c)
      for (int a = 0; a < 12; ++a) {
        double* column = rows.J[kJoinDofs * c + 12 * s + a];
        column[0] = root * (f.n[c] * Y22[a] + turn[c] * Y2[a]);
        column[1] = tilt * n[c] * Y2[a];
      }
  }
  rows.count = 2;
  rows.r[0] = sides.root * sides.jump;
  rows.r[1] = sides.stiff * sides.angle;
}

}  // namespace batten
