#include "batten/mesh/surface_search.h"

#include <boost/geometry.hpp>
#include <boost/geometry/geometries/box.hpp>
#include <boost/geometry/geometries/point.hpp>
#include <boost/geometry/index/rtree.hpp>

namespace batten {
namespace {

namespace bg = boost::geometry;
using Point = bg::model::point<double, 3, bg::cs::cartesian>;
using Box = bg::model::box<Point>;
using Entry = std::pair<Box, int>;

/// Barycentric coordinates of the nearest point of a triangle. Source: Ericson 2005, 5.1.5.
Vec3 nearest_in_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a, ac = c - a, ap = p - a;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return {1, 0, 0};
  const Vec3 bp = p - b;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return {0, 1, 0};
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return {1 - d1 / (d1 - d3), d1 / (d1 - d3), 0};
  const Vec3 cp = p - c;
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return {0, 0, 1};
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return {1 - d2 / (d2 - d6), 0, d2 / (d2 - d6)};
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 >= d3 && d5 >= d6) {
    const double w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return {0, 1 - w, w};
  }
  const double sum = va + vb + vc;
  return {va / sum, vb / sum, vc / sum};
}

}  // namespace

struct SurfaceSearch::Data {
  TriangleMesh mesh;
  bg::index::rtree<Entry, bg::index::quadratic<8>> tree;
};

SurfaceSearch::SurfaceSearch(const TriangleMesh& mesh) {
  std::vector<Entry> boxes;
  for (int t = 0; t < mesh.triangle_count(); ++t) {
    const auto& [a, b, c] = mesh.triangles()[t];
    const Vec3 low = mesh.point(a).cwiseMin(mesh.point(b)).cwiseMin(mesh.point(c)),
               high = mesh.point(a).cwiseMax(mesh.point(b)).cwiseMax(mesh.point(c));
    boxes.emplace_back(Box(Point(low[0], low[1], low[2]), Point(high[0], high[1], high[2])), t);
  }
  data_ = std::make_unique<Data>(
      Data{mesh, bg::index::rtree<Entry, bg::index::quadratic<8>>(boxes.begin(), boxes.end())});
}
SurfaceSearch::~SurfaceSearch() = default;

std::optional<SurfaceSearch::Found> SurfaceSearch::nearest(
    const Vec3& p, const std::optional<Vec3>& normal) const {
  const TriangleMesh& mesh = data_->mesh;
  const Point at(p[0], p[1], p[2]);
  std::optional<Found> best;
  // Boxes come in the order of their distance: none behind the best point can hold a nearer one.
  for (auto it =
           data_->tree.qbegin(bg::index::nearest(at, static_cast<unsigned>(mesh.triangle_count())));
       it != data_->tree.qend(); ++it) {
    if (best && bg::distance(at, it->first) > best->distance) break;
    const auto& [a, b, c] = mesh.triangles()[it->second];
    if (normal && mesh.area_vector(it->second).dot(*normal) <= 0) continue;
    const Vec3 w = nearest_in_triangle(p, mesh.point(a), mesh.point(b), mesh.point(c));
    const Vec3 q = w[0] * mesh.point(a) + w[1] * mesh.point(b) + w[2] * mesh.point(c);
    const double distance = (q - p).norm();
    if (!best || distance < best->distance) best = Found{it->second, q, w, distance};
  }
  return best;
}

}  // namespace batten
