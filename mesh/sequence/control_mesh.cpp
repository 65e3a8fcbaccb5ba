// SPDX-License-Identifier: MPL-2.0
#include "batten/mesh/sequence/control_mesh.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/parallel.h"
#include "batten/mesh/rotation_fitting.h"

#if BATTEN_HAVE_CGAL
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/alpha_wrap_3.h>
#endif

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

#if BATTEN_HAVE_CGAL

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Surface = CGAL::Surface_mesh<Kernel::Point_3>;

Surface wrapped(const std::vector<Kernel::Point_3>& points,
                const std::vector<std::vector<std::size_t>>& faces, double alpha, double offset) {
  Surface wrap;
  CGAL::alpha_wrap_3(points, faces, alpha, offset, wrap);
  return wrap;
}

TriangleMesh as_mesh(const Surface& wrap) {
  Points points(static_cast<long>(wrap.number_of_vertices()), 3);
  for (const auto v : wrap.vertices()) {
    const auto& p = wrap.point(v);
    points.row(static_cast<long>(v.idx())) << p.x(), p.y(), p.z();
  }
  std::vector<std::array<int, 3>> triangles;
  for (const auto f : wrap.faces()) {
    std::array<int, 3> t;
    int k = 0;
    for (const auto v : wrap.vertices_around_face(wrap.halfedge(f)))
      t[k++] = static_cast<int>(v.idx());
    triangles.push_back(t);
  }
  return TriangleMesh(std::move(points), std::move(triangles));
}

}  // namespace

TriangleMesh control_mesh(const TriangleMesh& mesh, const ControlMeshOptions& options) {
  if (options.vertices < 20 || options.vertices > 2000 ||
      !(options.distance >= 0.001 && options.distance <= 0.5))
    throw InputError("control mesh: found " + std::to_string(options.vertices) +
                     " vertices and a distance of " + std::to_string(options.distance) +
                     " of the size, expected 20 to 2000 and 0.001 to 0.5");
  if (mesh.triangle_count() == 0) throw InputError("control mesh: the mesh has no triangles");
  std::vector<Kernel::Point_3> points;
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    const Vec3 p = mesh.point(v);
    points.emplace_back(p[0], p[1], p[2]);
  }
  std::vector<std::vector<std::size_t>> faces;
  for (const auto& t : mesh.triangles())
    faces.push_back({static_cast<std::size_t>(t[0]), static_cast<std::size_t>(t[1]),
                     static_cast<std::size_t>(t[2])});
  const double size = mesh.size();
  // The number of vertices is proportional to 1 / alpha²: take a few secant steps on that.
  double alpha = size / 6;
  for (int trial = 0; trial < 8; ++trial) {
    const Surface wrap = wrapped(points, faces, alpha, options.distance * size);
    const auto count = static_cast<double>(wrap.number_of_vertices());
    const double ratio = count / options.vertices;
    if (ratio <= 1.25 && (ratio >= 0.6 || trial >= 5)) return as_mesh(wrap);
    alpha *= std::clamp(std::sqrt(ratio), 0.6, 2.0);
  }
  throw NoSolutionError("no closed mesh of about " + std::to_string(options.vertices) +
                        " vertices was found around the mesh; use more vertices or a larger "
                        "distance");
}

#else

TriangleMesh control_mesh(const TriangleMesh&, const ControlMeshOptions&) {
  throw InputError("Batten was built without CGAL and cannot create a control mesh; provide one");
}

#endif

}  // namespace batten
