#include <algorithm>
#include <cmath>

#include "batten/fairing/variation_geometry.h"
#include "batten/fairing/variation_terms.h"

namespace batten {
namespace {

using EdgeRow = Eigen::Matrix<double, kEdgeDofs, 1>;

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

  // Second derivative across the edge at Gauss point k, first side less second, over the dofs of
  // both.
  EdgeRow jump(size_t k) const {
    const auto& tables = HctTables::get();
    EdgeRow all = EdgeRow::Zero();
    for (size_t side = 0; side < 2; ++side) {
      // The edges run against each other.
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
  std::array<int, 12> slot_;  // of the second side's dofs
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

}  // namespace batten
