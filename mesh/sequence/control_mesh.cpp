#include "batten/mesh/sequence/control_mesh.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/parallel.h"
#include "batten/mesh/rotation_fitting.h"

namespace batten {
namespace {

using std::numbers::pi;

/// Adds the contributions of one triangle to the weights of its corners. Returns true if x lies on
/// the triangle; `w` is then complete.
bool add_triangle(const Eigen::Matrix<double, Eigen::Dynamic, 3>& u, const VecX& d,
                  const std::array<int, 3>& t, double size, VecX& w) {
  double angle[3], half = 0;
  for (int i = 0; i < 3; ++i) {
    const auto &p = u.row(t[(i + 1) % 3]), &q = u.row(t[(i + 2) % 3]);
    angle[i] = 2 * std::atan2((p - q).norm(), (p + q).norm());  // accurate to the last digit near π
                                                                // too
    half += angle[i] / 2;
  }
  if (pi - half < 1e-9) {  // on the triangle: barycentric coordinates
    w.setZero();
    for (int i = 0; i < 3; ++i)
      w[t[i]] = std::sin(angle[i]) * d[t[(i + 1) % 3]] * d[t[(i + 2) % 3]];
    return true;
  }
  double sine[3], c[3], s[3];
  for (int i = 0; i < 3; ++i) sine[i] = std::sin(angle[i]);
  const Vec3 a = u.row(t[0]), b = u.row(t[1]), e = u.row(t[2]);
  const double side = a.dot(b.cross(e)) < 0 ? -1 : 1;
  for (int i = 0; i < 3; ++i) {
    c[i] =
        2 * std::sin(half) * std::sin(half - angle[i]) / (sine[(i + 1) % 3] * sine[(i + 2) % 3]) -
        1;
    s[i] = side * std::sqrt(std::max(0.0, 1 - c[i] * c[i]));
    if (!(std::abs(s[i]) > 1e-9))
      return false;  // in the plane of the triangle but outside it: no
                     // contribution
  }
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    w[t[i]] += (angle[i] - c[j] * angle[k] - c[k] * angle[j]) / (d[t[i]] * sine[j] * s[k]) * size;
  }
  return false;
}

}  // namespace

MatX mean_value_coordinates(const TriangleMesh& control, const Points& points) {
  if (!control.topology().boundary_loops().empty() || control.triangle_count() == 0)
    throw InputError("the control mesh has free edges, expected a closed mesh");
  const int m = control.vertex_count();
  const double size = control.size();
  MatX W(points.rows(), m);
  parallel_chunks<64>(points.rows(), [&](long first, long last) {
    Eigen::Matrix<double, Eigen::Dynamic, 3> u(m, 3);
    VecX d(m), w(m);
    for (long x = first; x < last; ++x) {
      u = control.points().rowwise() - points.row(x);
      d = u.rowwise().norm();
      int nearest;
      w.setZero();
      if (d.minCoeff(&nearest) < 1e-12 * size) {
        w[nearest] = 1;
      } else {
        for (int j = 0; j < m; ++j) u.row(j) /= d[j];
        for (const auto& t : control.triangles())
          if (add_triangle(u, d, t, size, w)) break;
      }
      W.row(x) = w.transpose() / w.sum();
    }
  });
  return W;
}

ControlMeshTransfer::ControlMeshTransfer(const TriangleMesh& mesh, const Points& control,
                                         const MatX& W, int near)
    : mesh_(mesh), links_(control.rows()) {
  const auto n = static_cast<int>(W.rows());
  if (W.cols() != control.rows() || n > mesh.vertex_count() || near < 1)
    throw InputError("the mean value coordinates belong to a different control mesh");
  std::vector<int> order(n);
  for (int d = 0; d < W.cols(); ++d) {
    std::iota(order.begin(), order.end(), 0);
    const int count = std::min(near, n);
    std::partial_sort(order.begin(), order.begin() + count, order.end(),
                      [&](int a, int b) { return W(a, d) != W(b, d) ? W(a, d) > W(b, d) : a < b; });
    for (int k = 0; k < count; ++k) {
      links_[d].push_back({order[k], (control.row(d) - mesh.points().row(order[k])).transpose()});
      nodes_.push_back(order[k]);
    }
  }
  nodes_ = sorted_unique(std::move(nodes_));
}

Points ControlMeshTransfer::at(const Points& frame) const {
  if (frame.rows() != mesh_.topology().node_count())
    throw InputError("found a frame of " + std::to_string(frame.rows()) + " nodes, expected " +
                     std::to_string(mesh_.topology().node_count()));
  std::vector<Mat3> rotations(frame.rows());
  for (const int v : nodes_) {
    Mat3 M = Mat3::Zero();
    const MeshTopology& topology = mesh_.topology();
    for (const int same : topology.coincident_vertices(v))
      for (const int vertex : topology.neighbours(same)) {
        const int j = topology.node_of(vertex);
        M += (frame.row(j) - frame.row(v)).transpose() *
             (mesh_.points().row(j) - mesh_.points().row(v));
      }
    rotations[v] = nearest_rotation(M);
  }
  Points result(isize(links_), 3);
  for (size_t d = 0; d < links_.size(); ++d) {
    Vec3 sum = Vec3::Zero();
    for (const Link& link : links_[d])
      sum += frame.row(link.node).transpose() + rotations[link.node] * link.offset;
    result.row(static_cast<long>(d)) = sum.transpose() / static_cast<double>(links_[d].size());
  }
  return result;
}

}  // namespace batten
