#include "batten/fairing/normal_variation.h"

#include <Eigen/Geometry>
#include <cmath>

#include "batten/core/isize.h"

namespace batten {
namespace {

// N and its slopes: along u and v at vertices, across the edge at its midpoint. Second derivatives
// have a value for each triangle; the slopes are their means.
struct NormalField {
  std::vector<Vec3> vertex, by_u, by_v, edge, across;

  explicit NormalField(const Surface& surface)
      : vertex(surface.mesh().vertex_count(), Vec3::Zero()),
        by_u(vertex),
        by_v(vertex),
        edge(surface.mesh().edge_count(), Vec3::Zero()),
        across(edge) {
    const ParametricMesh& mesh = surface.mesh();
    std::vector<int> at_vertex(vertex.size()), at_edge(edge.size());
    for (int t = 0; t < mesh.triangle_count(); ++t)
      for (int i = 0; i < 3; ++i) {
        const int v = mesh.triangles()[t][i], e = mesh.edges_of(t)[i];
        Vec3 L = Vec3::Unit(i);
        Slopes slopes;
        vertex[v] += normal_at(surface.jet({t, L}), slopes);
        by_u[v] += slopes.col(0);
        by_v[v] += slopes.col(1);
        ++at_vertex[v];
        L = (Vec3::Ones() - Vec3::Unit(i)) / 2;
        edge[e] += normal_at(surface.jet({t, L}), slopes);
        across[e] += slopes * mesh.edge_normal(e);
        ++at_edge[e];
      }
    for (size_t v = 0; v < vertex.size(); ++v) {
      vertex[v].normalize();
      by_u[v] /= at_vertex[v];
      by_v[v] /= at_vertex[v];
    }
    for (size_t e = 0; e < edge.size(); ++e) {
      edge[e].normalize();
      across[e] /= at_edge[e];
    }
  }

  // Where a dof is.
  const Vec3& normal(int dof) const {
    const int edges = 3 * isize(vertex);
    return dof < edges ? vertex[dof / 3] : edge[dof - edges];
  }

 private:
  using Slopes = Eigen::Matrix<double, 3, 2>;

  // n_a = -Σ_b (g⁻¹ II)_ba X_b.
  static Vec3 normal_at(const SurfaceJet& jet, Slopes& slopes) {
    const Vec3 n = jet.normal();
    Slopes X;
    X << jet.x_u, jet.x_v;
    const double uv = n.dot(jet.x_uv);
    Mat2 II;
    II << n.dot(jet.x_uu), uv, uv, n.dot(jet.x_vv);
    slopes = -X * ((X.transpose() * X).inverse() * II);
    return n;
  }
};

}  // namespace

NormalVariation::NormalVariation(const BlockReduction& reduction, const Surface& start)
    : reduction_(reduction), unknown_of_(reduction.dof_count(), -1) {
  const int n = reduction.dof_count();
  const NormalField field(start);
  std::vector<Vec3> ways(n, Vec3::Zero());  // of a unit step along the free coordinates
  for (int f = 0; f < reduction.free_count(); ++f) {
    const int row = reduction.free_rows()[f], dof = row % n;
    const double step = field.normal(dof)[row / n];
    for (int c = 0; c < 3; ++c) ways[dof][c] += reduction.D().coeff(c * n + dof, f) * step;
  }
  for (int dof = 0; dof < n; ++dof)
    if (const double length = ways[dof].norm();
        length > 0.1 && field.normal(dof).dot(ways[dof]) > 0.5 * length)
      unknown_of_[dof] = count_++;
}

template <class Put>
void NormalVariation::scalar_row(int dof, const Put& put) const {
  if (unknown_of_[dof] >= 0 || reduction_.coupled()) {
    if (unknown_of_[dof] >= 0) put(unknown_of_[dof], 1.0);
    return;
  }
  for (RowMatrix::InnerIterator it(reduction_.D(), dof); it; ++it)
    if (const int unknown = unknown_of_[reduction_.free_rows()[it.col()]]; unknown >= 0)
      put(unknown, it.value());
}

RowMatrix NormalVariation::reduced_rows(const RowMatrix& rows) const {
  std::vector<Triplet> entries;
  for (int r = 0; r < rows.rows(); ++r)
    for (RowMatrix::InnerIterator it(rows, r); it; ++it)
      scalar_row(static_cast<int>(it.col()), [&](int unknown, double fraction) {
        entries.emplace_back(r, unknown, it.value() * fraction);
      });
  RowMatrix own(rows.rows(), count_);
  own.setFromTriplets(entries.begin(), entries.end());
  return own;
}

RowMatrix NormalVariation::at(const Surface& surface) const {
  const int n = reduction_.dof_count(), edges = surface.dof_map().edge(0);
  const ParametricMesh& mesh = surface.mesh();
  const NormalField field(surface);
  std::vector<Triplet> entries;
  for (int f = 0; f < reduction_.free_count(); ++f) {
    const int row = reduction_.free_rows()[f], dof = row % n, c = row / n;
    const auto add = [&](int of, double factor) {
      scalar_row(of, [&](int unknown, double fraction) {
        entries.emplace_back(f, unknown, factor * fraction);
      });
    };
    if (unknown_of_[dof] >= 0) add(dof, field.normal(dof)[c]);
    if (dof < edges) {
      const int v = dof / 3, slope = dof % 3;
      if (slope > 0) add(3 * v, (slope == 1 ? field.by_u : field.by_v)[v][c]);
    } else {
      const int e = dof - edges;
      // φ at the midpoint, by Hermite's cubic along the edge.
      const Vec2 edge_step = mesh.edge_length(e) / 8 * mesh.edge_tangent(e);
      const double across = field.across[e][c];
      for (const auto& [v, sign] :
           {std::pair{mesh.edges()[e].low, 1}, std::pair{mesh.edges()[e].high, -1}}) {
        add(3 * v, across / 2);
        add(3 * v + 1, sign * across * edge_step.x());
        add(3 * v + 2, sign * across * edge_step.y());
      }
    }
  }
  RowMatrix steps(reduction_.free_count(), count_);
  steps.setFromTriplets(entries.begin(), entries.end());
  return reduction_.D() * steps;
}

}  // namespace batten
