// SPDX-License-Identifier: MPL-2.0
// Reference implementation of frames of sequences with dense matrices, and test shapes.
#pragma once

#include <map>

#include "batten/core/eigen.h"
#include "batten/mesh/prepared_mesh.h"
#include "batten/mesh/rotation_fitting.h"
#include "batten/mesh/sequence/frame_solver.h"
#include "batten/mesh/sequence/trajectories/rigid_motion.h"
#include "batten/tests/support/random_motion.h"
#include "batten/tests/support/sample_meshes.h"

namespace batten_test {

/// The closed surface of a box, x in [0, length], y and z in [-width/2, width/2]; n divisions
/// along, m across.
inline TriangleMesh bar(int n, int m, double length, double width) {
  std::map<std::array<int, 3>, int> number;
  std::vector<Vec3> p;
  const auto node = [&](int i, int j, int k) {
    const auto [at, is_new] = number.emplace(std::array{i, j, k}, static_cast<int>(p.size()));
    if (is_new) p.push_back({length * i / n, width * (j - 0.5 * m) / m, width * (k - 0.5 * m) / m});
    return at->second;
  };
  std::vector<std::array<int, 3>> triangles;
  const auto quad = [&](int a, int b, int c, int d) {
    triangles.insert(triangles.end(), {{a, b, c}, {a, c, d}});
  };
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < m; ++j) {
      quad(node(i, j, m), node(i + 1, j, m), node(i + 1, j + 1, m), node(i, j + 1, m));
      quad(node(i, j, 0), node(i, j + 1, 0), node(i + 1, j + 1, 0), node(i + 1, j, 0));
      quad(node(i, 0, j), node(i + 1, 0, j), node(i + 1, 0, j + 1), node(i, 0, j + 1));
      quad(node(i, m, j), node(i, m, j + 1), node(i + 1, m, j + 1), node(i + 1, m, j));
    }
  for (int j = 0; j < m; ++j)
    for (int k = 0; k < m; ++k) {
      quad(node(0, j, k), node(0, j, k + 1), node(0, j + 1, k + 1), node(0, j + 1, k));
      quad(node(n, j, k), node(n, j + 1, k), node(n, j + 1, k + 1), node(n, j, k + 1));
    }
  Points points(static_cast<int>(p.size()), 3);
  for (size_t v = 0; v < p.size(); ++v) points.row(static_cast<int>(v)) = p[v];
  return {points, triangles};
}

/// A plate and a wall on its centre line: a T-joint. 2 n squares along, n across.
inline PreparedMesh plate_with_wall(int n) {
  ShellMesh shells;
  std::map<std::array<int, 3>, int> number;
  std::vector<Vec3> p;
  const auto node = [&](int i, int j, int k) {
    const auto [at, is_new] = number.emplace(std::array{i, j, k}, static_cast<int>(p.size()));
    if (is_new) p.push_back({1.0 * i / n, 1.0 * j / n, 0.9 * k / n});
    return at->second;
  };
  for (int i = 0; i < 2 * n; ++i) {
    for (int j = -n / 2; j < n / 2; ++j)
      shells.add_face(
          std::array{node(i, j, 0), node(i + 1, j, 0), node(i + 1, j + 1, 0), node(i, j + 1, 0)});
    for (int k = 0; k < n / 2; ++k)
      shells.add_face(
          std::array{node(i, 0, k), node(i + 1, 0, k), node(i + 1, 0, k + 1), node(i, 0, k + 1)});
  }
  shells.points.resize(static_cast<int>(p.size()), 3);
  for (size_t v = 0; v < p.size(); ++v) shells.points.row(static_cast<int>(v)) = p[v];
  return prepare(shells);
}

template <class Wanted>
std::vector<int> nodes_where(const Points& points, const Wanted& wanted) {
  std::vector<int> nodes;
  for (int v = 0; v < points.rows(); ++v)
    if (wanted(Vec3(points.row(v)))) nodes.push_back(v);
  return nodes;
}

/// Unique edges between nodes.
inline std::vector<std::pair<int, int>> node_edges(const TriangleMesh& mesh) {
  std::vector<std::pair<int, int>> edges;
  for (const auto& t : mesh.triangles())
    for (int c = 0; c < 3; ++c)
      edges.push_back(
          std::minmax({mesh.topology().node_of(t[c]), mesh.topology().node_of(t[(c + 1) % 3])}));
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  return edges;
}

/// Σ_i Σ_j |(v_j - v_i) - R_i (p_j - p_i)|².
inline double arap_energy(const TriangleMesh& mesh, const Points& p, const Points& v,
                          const std::vector<Mat3>& rotations) {
  double energy = 0;
  for (const auto& [a, b] : node_edges(mesh))
    for (const int i : {a, b})
      energy +=
          ((v.row(b) - v.row(a)).transpose() - rotations[i] * (p.row(b) - p.row(a)).transpose())
              .squaredNorm();
  return energy;
}

/// R_i of all one-rings.
inline std::vector<Mat3> local_rotations(const TriangleMesh& mesh, const Points& p,
                                         const Points& v) {
  std::vector<Mat3> sums(p.rows(), Mat3::Zero());
  for (const auto& [a, b] : node_edges(mesh)) {
    const Mat3 M = (v.row(b) - v.row(a)).transpose() * (p.row(b) - p.row(a));
    sums[a] += M, sums[b] += M;
  }
  for (Mat3& M : sums) M = nearest_rotation(M);
  return sums;
}

/// min over v of arap_energy + λ Σ |v_h - u_h|² subject to C v = d, by one dense KKT matrix:
/// equations of all three coordinates of all nodes, without elimination.
class ReferenceFrameSolver {
 public:
  ReferenceFrameSolver(const TriangleMesh& mesh, const Points& p,
                       const std::vector<Mat3>& rotations)
      : p_(p),
        n_(static_cast<int>(p.rows())),
        H_(MatX::Zero(3 * n_, 3 * n_)),
        f_(VecX::Zero(3 * n_)) {
    for (const auto& [a, b] : node_edges(mesh))
      for (const int i : {a, b}) {
        const Vec3 to = rotations[i] * (p.row(b) - p.row(a)).transpose();
        for (int c = 0; c < 3; ++c) {
          const int s = 3 * a + c, t = 3 * b + c;
          H_(s, s) += 1, H_(t, t) += 1, H_(s, t) -= 1, H_(t, s) -= 1;
          f_[t] += to[c], f_[s] -= to[c];
        }
      }
  }
  void add_soft_target(int node, const Vec3& to, double lambda) {
    for (int c = 0; c < 3; ++c) H_(3 * node + c, 3 * node + c) += lambda;
    f_.segment<3>(3 * node) += lambda * to;
  }
  void fix(int node, const Vec3& at) {
    for (int c = 0; c < 3; ++c) row({{3 * node + c, 1.0}}, at[c]);
  }
  /// The nodes keep their shape up to a rotation.
  void rigid(const std::vector<int>& nodes, const Mat3& rotation) {
    for (size_t k = 1; k < nodes.size(); ++k) {
      const Vec3 arm = rotation * (p_.row(nodes[k]) - p_.row(nodes[0])).transpose();
      for (int c = 0; c < 3; ++c) row({{3 * nodes[k] + c, 1.0}, {3 * nodes[0] + c, -1.0}}, arm[c]);
    }
  }
  void on_plane(int node, const Vec3& normal, const Vec3& at) {
    row({{3 * node, normal[0]}, {3 * node + 1, normal[1]}, {3 * node + 2, normal[2]}},
        normal.dot(at));
  }
  void mean(const std::vector<int>& nodes, const Vec3& at) {
    for (int c = 0; c < 3; ++c) {
      std::vector<std::pair<int, double>> entries;
      for (const int v : nodes) entries.emplace_back(3 * v + c, 1.0 / nodes.size());
      row(entries, at[c]);
    }
  }
  Points solve() const {
    const int m = static_cast<int>(d_.size()), n = 3 * n_;
    MatX K = MatX::Zero(n + m, n + m);
    VecX rhs(n + m);
    K.topLeftCorner(n, n) = H_;
    rhs.head(n) = f_;
    for (int r = 0; r < m; ++r) {
      for (const auto& [c, x] : constraints_[r]) K(n + r, c) = K(c, n + r) = x;
      rhs[n + r] = d_[r];
    }
    const VecX x = least_squares(K, rhs);
    Points v(n_, 3);
    for (int i = 0; i < n_; ++i) v.row(i) = x.segment<3>(3 * i);
    return v;
  }

 private:
  void row(std::vector<std::pair<int, double>> entries, double d) {
    constraints_.push_back(std::move(entries));
    d_.push_back(d);
  }
  Points p_;
  int n_;
  MatX H_;
  VecX f_;
  std::vector<std::vector<std::pair<int, double>>> constraints_;
  std::vector<double> d_;
};

/// Largest deviation of some nodes from a rigid copy of their shape.
inline double bent(const Points& before, const Points& after, const std::vector<int>& nodes) {
  double most = 0;
  for (const int a : nodes)
    for (const int b : nodes)
      most = std::max(most, std::abs((after.row(a) - after.row(b)).norm() -
                                     (before.row(a) - before.row(b)).norm()));
  return most;
}

}  // namespace batten_test
