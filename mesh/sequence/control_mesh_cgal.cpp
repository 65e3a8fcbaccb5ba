#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/alpha_wrap_3.h>

#include <cmath>

#include "batten/core/errors.h"
#include "batten/mesh/sequence/control_mesh.h"

namespace batten {
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

}  // namespace batten
