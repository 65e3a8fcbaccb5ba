// SPDX-License-Identifier: MPL-2.0
// One mesh of a model: watertight across faces, normals of the faces, curves as polylines.
#include "batten/skinning/facets/welded_mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/mesh/editing/mesh_editor.h"
#include "batten/mesh/prepared_mesh.h"
#include "batten/skinning/domains/mesher.h"
#include "batten/skinning/search/find_regions.h"
#include "batten/skinning/surfaces/skin_network.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/sample_networks.h"
#include "batten/tests/support/trimmed_regions.h"

using namespace batten_test;

namespace {

using Edge = std::pair<int, int>;

Edge undirected(int a, int b) { return std::minmax(a, b); }

Vec3 point(const WeldedMesh& mesh, int v) { return mesh.points.row(v).transpose(); }
Vec3 normal(const WeldedMesh& mesh, int row) { return mesh.normals.row(row).transpose(); }

Vec3 area_vector(const Points& points, const std::array<int, 3>& t) {
  const Vec3 a = points.row(t[0]), b = points.row(t[1]), c = points.row(t[2]);
  return 0.5 * (b - a).cross(c - a);
}

double enclosed_volume(const WeldedMesh& mesh) {
  double volume = 0;
  for (const auto& t : mesh.triangles)
    volume += point(mesh, t[0]).dot(area_vector(mesh.points, t)) / 3;
  return volume;
}

/// The edges of a mesh, by their number of triangles.
struct EdgeCount {
  int free = 0, inner = 0, non_manifold = 0;
  int same_direction = 0;  ///< directed edges with several triangles
  int euler = 0;           ///< vertices of triangles - edges + triangles
  std::set<Edge> all, not_inner;

  explicit EdgeCount(const WeldedMesh& mesh) {
    std::map<Edge, int> count, directed;
    std::set<int> used;
    for (const auto& t : mesh.triangles)
      for (size_t i = 0; i < 3; ++i) {
        used.insert(t[i]);
        ++count[undirected(t[i], t[(i + 1) % 3])];
        same_direction += ++directed[{t[i], t[(i + 1) % 3]}] == 2;
      }
    for (const auto& [edge, triangles] : count) {
      ++(triangles == 1 ? free : triangles == 2 ? inner : non_manifold);
      all.insert(edge);
      if (triangles != 2) not_inner.insert(edge);
    }
    euler = static_cast<int>(used.size() + mesh.triangles.size()) - static_cast<int>(count.size());
    CHECK(static_cast<long>(used.size()) == mesh.points.rows());
  }
  bool is_closed_and_oriented() const {
    return free == 0 && non_manifold == 0 && same_direction == 0;
  }
};

const WeldedCurve& curve_named(const WeldedMesh& mesh, const std::string& name) {
  const auto found = std::find_if(mesh.curves.begin(), mesh.curves.end(),
                                  [&](const WeldedCurve& c) { return c.name == name; });
  REQUIRE(found != mesh.curves.end());
  return *found;
}

std::set<Edge> edges_on(const WeldedCurve& curve) {
  std::set<Edge> edges;
  for (const auto& [vertices, closed] : curve.polylines) {
    for (size_t i = 0; i + 1 < vertices.size(); ++i)
      edges.insert(undirected(vertices[i], vertices[i + 1]));
    if (closed) edges.insert(undirected(vertices.back(), vertices.front()));
  }
  return edges;
}

/// Properties of all welded meshes. `tolerance`: distance of the surfaces from their curves.
void check_consistent(const WeldedMesh& mesh, const std::vector<const SkinnedRegion*>& regions,
                      double tolerance) {
  const EdgeCount edges(mesh);
  REQUIRE(mesh.region.size() == mesh.triangles.size());
  REQUIRE(mesh.normals.rows() == 3 * static_cast<long>(mesh.triangles.size()));
  // Curves are chains of edges near the curves of the faces; free edges are on curves.
  std::set<Edge> on_curves;
  bool are_edges = true;
  double away = 0;
  for (const WeldedCurve& curve : mesh.curves) {
    const std::set<Edge> own = edges_on(curve);
    on_curves.insert(own.begin(), own.end());
    for (const Edge& e : own) are_edges = are_edges && edges.all.count(e);
    for (const SkinnedRegion* region : regions) {
      const auto compare = [&](const auto& line) {
        if (line.line.name != curve.name) return;
        for (const auto& polyline : curve.polylines)
          for (const int v : polyline.vertices)
            away = std::max(away, line.fitted.closest_point(point(mesh, v)).distance);
      };
      for (const EdgeAlignedLine& line : region->edge_aligned) compare(line);
      for (const EmbeddedLine& line : region->embedded) compare(line);
    }
  }
  CHECK(are_edges);
  CHECK(away <= tolerance);
  CHECK(std::includes(on_curves.begin(), on_curves.end(), edges.not_inner.begin(),
                      edges.not_inner.end()));
  // No triangle is degenerate or turned over; normals are unit vectors.
  double length_error = 0, smallest_cosine = 1;
  for (int t = 0; t < static_cast<int>(mesh.triangles.size()); ++t) {
    const Vec3 flat = area_vector(mesh.points, mesh.triangles[static_cast<size_t>(t)]).normalized();
    for (int c = 0; c < 3; ++c) {
      const Vec3 n = normal(mesh, 3 * t + c);
      length_error = std::max(length_error, std::abs(n.norm() - 1));
      smallest_cosine = std::min(smallest_cosine, n.dot(flat));
    }
  }
  CHECK(length_error < 1e-14);
  CHECK(smallest_cosine > 0.8);
  // Vertices are on the surfaces, with their normals. The search is slow: a sample of corners.
  const int corners = static_cast<int>(mesh.normals.rows()), step = std::max(1, corners / 60);
  double off = 0, turned = 0;
  for (int k = 0; k < corners; k += step) {
    const size_t t = static_cast<size_t>(k / 3);
    const Surface& surface = regions[static_cast<size_t>(mesh.region[t])]->surface;
    const auto closest = surface.closest_point(point(mesh, mesh.triangles[t][k % 3]));
    off = std::max(off, closest.distance);
    turned = std::max(turned, (surface.jet(closest.where).normal() - normal(mesh, k)).norm());
  }
  CHECK(off <= tolerance);
  CHECK(turned < 1e-6 + 20 * tolerance);
}

SurfaceModel model_of(const std::vector<CharacterLine>& lines, double edge_length,
                      const RegionSearchOptions& search = {}, double crease_angle_deg = 25) {
  ModelOptions options;
  options.skin.edge_length = edge_length;
  options.crease_angle_deg = crease_angle_deg;
  const CurveNetwork network(lines);
  return skin_network(network, find_regions(network, search), options);
}

RegionSpec face_of(std::vector<std::vector<std::string>> loops, bool annulus = false) {
  RegionSpec spec;
  spec.loops = std::move(loops);
  spec.annulus = annulus;
  return spec;
}

CharacterLine circle_in_space(const std::string& name, const Vec3& centre, const Vec3& a,
                              const Vec3& b) {
  return {name, curve_from_formula(0, 2 * pi, [=](double t, int order) -> Vec3 {
            if (order == 0) return centre + a * std::cos(t) + b * std::sin(t);
            if (order == 1) return -a * std::sin(t) + b * std::cos(t);
            return -a * std::cos(t) - b * std::sin(t);
          })};
}

/// The unit square with n × n × 2 elements, mapped by `shape` (u, v) → SurfaceJet, with its sides
/// (south, east, north, west) as mesh-aligned curves around it.
template <class Shape>
SkinnedRegion mapped_square(int n, const std::array<std::string, 4>& sides, const Shape& shape) {
  const auto mesh = std::make_shared<const ParametricMesh>(ParametricMesh::unit_square(n));
  SkinnedRegion region{
      "square", interpolated(mesh, TriangleElement::HCT, shape), {}, std::sqrt(2), {}, {{}}};
  const int first[] = {0, n, (n + 1) * (n + 1) - 1, n * (n + 1)}, step[] = {1, n + 1, -1, -n - 1};
  const Vec2 corner[] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  for (size_t s = 0; s < 4; ++s) {
    EdgeAlignedLine side;
    side.line.name = sides[s];
    for (int i = 0; i <= n; ++i) {
      side.vertices.push_back(first[s] + i * step[s]);
      side.parameters.push_back(static_cast<double>(i) / n);
      if (i > 0) side.edges.push_back(mesh->edge_between(side.vertices[i - 1], side.vertices[i]));
    }
    const Vec2 from = corner[s], along = corner[(s + 1) % 4] - corner[s];
    side.fitted = hermite(0, 1, n, false, [&](double t, int order) -> Vec3 {
      const SurfaceJet jet = shape(from + t * along);
      return order == 0 ? jet.x : Vec3(along.x() * jet.x_u + along.y() * jet.x_v);
    });
    region.edge_aligned.push_back(side);
    region.boundary[0].push_back({BoundarySegment::Kind::EdgeAligned, static_cast<int>(s), false});
  }
  return region;
}

/// A flat unit square, moved.
SkinnedRegion flat_square(int n, const Vec3& origin, const std::array<std::string, 4>& sides) {
  return mapped_square(n, sides, [&](const Vec2& p) {
    return SurfaceJet{origin + Vec3(p.x(), p.y(), 0),
                      Vec3::UnitX(),
                      Vec3::UnitY(),
                      Vec3::Zero(),
                      Vec3::Zero(),
                      Vec3::Zero()};
  });
}

}  // namespace

TEST_CASE("a box of six faces is one closed mesh without duplicate vertices",
          "[skinning][facets]") {
  if (!have_delaunay_mesher()) return;
  const SurfaceModel model = model_of(box_lines(Vec3::Zero(), {1, 2, 3}), 0.4);
  const auto faces = model.skinned();
  REQUIRE(faces.size() == 6);
  const int n = GENERATE(1, 2, 3, 4);
  INFO("n = " << n);
  const WeldedMesh mesh = welded_mesh(faces, n);
  check_consistent(mesh, faces, 1e-10);
  const EdgeCount edges(mesh);
  CHECK(edges.is_closed_and_oriented());
  CHECK(edges.euler == 2);
  CHECK(enclosed_volume(mesh) == Approx(6).epsilon(1e-9));

  // Vertices: those of two faces on each curve and of three faces at each corner are one.
  long separate = 0, facet_count = 0, on_curves = 0;
  for (const SkinnedRegion* face : faces) {
    const Tessellation own = facets(*face, n).tessellation;
    separate += static_cast<long>(own.points.size());
    facet_count += static_cast<long>(own.facets.size());
  }
  REQUIRE(mesh.curves.size() == 12);
  std::set<int> corners;
  for (const WeldedCurve& curve : mesh.curves) {
    REQUIRE(curve.polylines.size() == 1);
    CHECK_FALSE(curve.polylines[0].closed);
    const auto& vertices = curve.polylines[0].vertices;
    corners.insert({vertices.front(), vertices.back()});
    on_curves += static_cast<long>(vertices.size()) - 2;
  }
  CHECK(corners.size() == 8);
  CHECK(mesh.points.rows() == separate - on_curves - 2 * 8);
  CHECK(static_cast<long>(mesh.triangles.size()) == facet_count);

  // Normals: those of the planes, three different ones at each corner, two on each curve.
  std::map<int, std::vector<Vec3>> normals;
  double error = 0;
  for (int k = 0; k < mesh.normals.rows(); ++k) {
    const auto& triangle = mesh.triangles[static_cast<size_t>(k / 3)];
    Vec3 nearest = Vec3::Zero(), n_k = normal(mesh, k);
    int axis = 0;
    n_k.cwiseAbs().maxCoeff(&axis);
    nearest[axis] = point(mesh, triangle[0])[axis] > 0.5 ? 1 : -1;
    error = std::max(error, (n_k - nearest).norm());
    auto& known = normals[triangle[k % 3]];
    if (std::none_of(known.begin(), known.end(), [&](const Vec3& m) { return m.dot(n_k) > 0.9; }))
      known.push_back(n_k);
  }
  CHECK(error < 1e-8);
  std::map<size_t, long> vertices_with;
  for (const auto& [vertex, all] : normals) ++vertices_with[all.size()];
  CHECK(vertices_with[3] == 8);
  CHECK(vertices_with[2] == on_curves);
  CHECK(vertices_with.size() == 3);
}

TEST_CASE("the volume of a closed curved mesh converges to that of the surface",
          "[skinning][facets]") {
  if (!have_delaunay_mesher()) return;
  const SurfaceModel model = model_of(sphere_lines(), 0.4);
  const auto faces = model.skinned();
  REQUIRE(faces.size() == 8);
  double before = 0;
  for (const int n : {1, 2, 4}) {
    const WeldedMesh mesh = welded_mesh(faces, n);
    check_consistent(mesh, faces, 1e-10);
    const EdgeCount edges(mesh);
    CHECK(edges.is_closed_and_oriented());
    CHECK(edges.euler == 2);
    const double error = model.shells[0].volume - enclosed_volume(mesh);
    CHECK(error > 0);
    if (n > 1) CHECK(std::log2(before / error) == Approx(2).margin(0.1));
    before = error;
  }
}

TEST_CASE("a can: a mesh-aligned tube and the embedded boundaries of its ends are welded",
          "[skinning][facets]") {
  if (!have_delaunay_mesher()) return;
  const double length = GENERATE(0.0, 0.07, 0.6);
  const int n = GENERATE(1, 3);
  const double sense = n == 1 ? 1 : -1;  // of the second circle
  INFO("edge length " << length << ", n = " << n);
  const Vec3 x = Vec3::UnitX(), y = Vec3::UnitY();
  RegionSearchOptions search;
  search.specs = {face_of({{"low"}, {"high"}}, true), face_of({{"low"}}), face_of({{"high"}})};
  const SurfaceModel model = model_of({circle_in_space("low", Vec3::Zero(), x, y),
                                       circle_in_space("high", {0, 0, 2}, x, sense * y)},
                                      0.3, search, -1);
  const auto faces = model.skinned();
  REQUIRE(faces.size() == 3);
  CHECK(faces[0]->edge_aligned.size() == 2);
  CHECK(faces[1]->embedded.size() == 1);
  const WeldedMesh mesh = welded_mesh(faces, n, length);
  check_consistent(mesh, faces, 2e-4 * faces[0]->size);
  const EdgeCount edges(mesh);
  CHECK(edges.is_closed_and_oriented());
  CHECK(edges.euler == 2);
  CHECK(enclosed_volume(mesh) == Approx(model.shells[0].volume).epsilon(0.1 / (n * n)));
  REQUIRE(mesh.curves.size() == 2);
  for (const WeldedCurve& curve : mesh.curves) {
    REQUIRE(curve.polylines.size() == 1);
    CHECK(curve.polylines[0].closed);
    const auto& vertices = curve.polylines[0].vertices;
    CHECK(std::set<int>(vertices.begin(), vertices.end()).size() == vertices.size());
    CHECK(vertices.size() >= static_cast<size_t>(n) * faces[0]->edge_aligned[0].edges.size());
    // The tube is on the circle between the nodes of its cubics as well; its ends follow it.
    for (const int v : vertices) CHECK(point(mesh, v).head<2>().norm() == Approx(1).margin(2e-4));
  }

  // The tube alone: closed around u, with two free boundaries.
  const WeldedMesh tube = welded_mesh({faces[0]}, n);
  const EdgeCount of_tube(tube);
  CHECK(of_tube.euler == 0);
  CHECK(of_tube.free == 2 * n * static_cast<int>(faces[0]->edge_aligned[0].edges.size()));
  CHECK(of_tube.non_manifold == 0);
  for (const WeldedCurve& curve : tube.curves) CHECK(curve.polylines[0].closed);
}

TEST_CASE("a sheet with a hole and an inner curve: free edges, polylines and exact normals",
          "[skinning][facets]") {
  if (!have_delaunay_mesher()) return;
  const SkinnedRegion disc = wavy_disc({});
  const int n = GENERATE(1, 2, 5);
  const WeldedMesh mesh = welded_mesh({&disc}, n);
  check_consistent(mesh, {&disc}, 1e-3);
  const EdgeCount edges(mesh);
  CHECK(edges.euler == 0);
  CHECK(edges.non_manifold == 0);
  CHECK(edges.same_direction == 0);
  const WeldedCurve &rim = curve_named(mesh, "rim"), &hole = curve_named(mesh, "hole"),
                    &rib = curve_named(mesh, "rib");
  std::set<Edge> boundary = edges_on(rim);
  boundary.merge(edges_on(hole));
  CHECK(boundary == edges.not_inner);
  for (const WeldedCurve* closed : {&rim, &hole}) {
    REQUIRE(closed->polylines.size() == 1);
    CHECK(closed->polylines[0].closed);
  }
  REQUIRE(rib.polylines.size() == 1);
  CHECK_FALSE(rib.polylines[0].closed);
  const auto is_on = [](const WeldedCurve& curve, int v) {
    const auto& all = curve.polylines[0].vertices;
    return std::count(all.begin(), all.end(), v) == 1;
  };
  CHECK(is_on(rim, rib.polylines[0].vertices.front()));
  CHECK(is_on(hole, rib.polylines[0].vertices.back()));
  // x = u and y = v on this sheet: the normal is known at every vertex.
  double error = 0, off = 0;
  for (int k = 0; k < mesh.normals.rows(); ++k) {
    const Vec3 p = point(mesh, mesh.triangles[static_cast<size_t>(k / 3)][k % 3]);
    const SurfaceJet jet = disc.surface.jet(disc.surface.locate(p.head<2>()));
    error = std::max(error, (jet.normal() - normal(mesh, k)).norm());
    off = std::max(off, (jet.x - p).norm());
  }
  CHECK(error < 1e-12);
  CHECK(off < 1e-12);
}

TEST_CASE("faces with different vertices on their common curve get the same ones",
          "[skinning][facets]") {
  if (!have_delaunay_mesher()) return;
  const int n = GENERATE(1, 2, 3);
  SECTION("mesh-aligned in both faces") {
    const SkinnedRegion a = flat_square(4, {0, 0, 0}, {"a1", "common", "a3", "a4"}),
                        b = flat_square(6, {1, 0, 0}, {"b1", "b2", "b3", "common"});
    const WeldedMesh mesh = welded_mesh({&a, &b}, n);
    check_consistent(mesh, {&a, &b}, 1e-14);
    const EdgeCount edges(mesh);
    CHECK(edges.euler == 1);
    CHECK(edges.same_direction == 0);
    CHECK(edges.non_manifold == 0);
    const auto& common = curve_named(mesh, "common").polylines;
    REQUIRE(common.size() == 1);
    CHECK_FALSE(common[0].closed);
    // Fractions k/4 and k/6 of the curve.
    CHECK(common[0].vertices.size() == static_cast<size_t>(8 * n + 1));
    CHECK(point(mesh, common[0].vertices.front()).y() == 0);
    CHECK(point(mesh, common[0].vertices.back()).y() == 1);
    double area = 0;
    for (const auto& t : mesh.triangles) area += area_vector(mesh.points, t).z();
    CHECK(area == Approx(2).epsilon(1e-13));
  }
  SECTION("embedded in both faces, in opposite directions") {
    const SkinnedRegion around =
        sheet_region({circle({0, 0}, 1, 24), circle({0.1, 0.2}, 0.5, 8)}, {}, 0.2);
    SkinnedRegion inside = sheet_region({circle({0.1, 0.2}, 0.5, 8)}, {}, 0.06);
    EmbeddedLine& rim = inside.embedded[0];
    rim.line.name = "hole";
    rim.fitted = rim.fitted.backwards();
    rim.pcurve = rim.pcurve.backwards();
    inside.boundary[0][0].reversed = !inside.boundary[0][0].reversed;
    const WeldedMesh mesh = welded_mesh({&around, &inside}, n);
    check_consistent(mesh, {&around, &inside}, 2e-3);
    const EdgeCount edges(mesh);
    CHECK(edges.euler == 1);
    CHECK(edges.same_direction == 0);
    CHECK(edges.not_inner == edges_on(curve_named(mesh, "rim")));
    const WeldedMesh finer = welded_mesh({&around, &inside}, n, 0.05);
    CHECK(edges_on(curve_named(finer, "rim")).size() == Approx(2 * pi * n / 0.05).epsilon(0.2));
    // The common vertices are exactly on the curve.
    for (const int v : curve_named(mesh, "hole").polylines[0].vertices)
      CHECK(around.embedded[1].fitted.closest_point(point(mesh, v)).distance < 1e-12);
  }
}

TEST_CASE("an inner curve through several faces is one polyline", "[skinning][facets]") {
  if (!have_delaunay_mesher()) return;
  // The curve crosses a hole, which another face fills. In that face, it runs backwards.
  const HermiteCurve rim = circle({0, 0}, 1, 24), hole = circle({0.1, 0.2}, 0.4, 8);
  const bool inside_first = GENERATE(false, true);
  // Starts outside of the hole, or inside of it.
  const double x0 = inside_first ? GENERATE(-0.7, 0.05) : 0.05;
  const HermiteCurve rib = hermite(0, 1, 6, false, [&](double t, int order) {
    return order == 0 ? Vec3(x0 + t * (0.8 - x0), 0.2 + 0.1 * t, 0) : Vec3(0.8 - x0, 0.1, 0);
  });
  const SkinnedRegion around = sheet_region({rim, hole}, {rib}, 0.2);
  SkinnedRegion inside = sheet_region({hole}, {rib.backwards()}, 0.13);
  inside.embedded[0].line.name = "hole";
  std::vector<const SkinnedRegion*> faces{&around, &inside};
  if (inside_first) std::swap(faces[0], faces[1]);
  const WeldedMesh mesh = welded_mesh(faces, 2);
  check_consistent(mesh, faces, 2e-3);
  const auto& polylines = curve_named(mesh, "rib").polylines;
  REQUIRE(polylines.size() == 1);
  CHECK_FALSE(polylines[0].closed);
  // In the direction of the curve in the first face.
  std::vector<int> vertices = polylines[0].vertices;
  if (inside_first) std::reverse(vertices.begin(), vertices.end());
  for (size_t i = 0; i + 1 < vertices.size(); ++i)
    CHECK(point(mesh, vertices[i]).x() < point(mesh, vertices[i + 1]).x());
  CHECK(point(mesh, vertices.front()).x() == Approx(x0));
  CHECK(point(mesh, vertices.back()).x() == Approx(0.8));
  const WeldedMesh alone = welded_mesh({&around}, 2);
  CHECK(curve_named(alone, "rib").polylines.size() == (x0 < 0 ? 2 : 1));
}

TEST_CASE("sheets without a common curve are not welded, however close they are",
          "[skinning][facets]") {
  if (!have_delaunay_mesher()) return;
  const double gap = GENERATE(0.1, 1e-3, 1e-5);
  INFO("gap " << gap);
  const SkinnedRegion low = flat_square(3, {0, 0, 0}, {"a1", "a2", "a3", "a4"}),
                      high = flat_square(3, {0, 0, gap}, {"b1", "b2", "b3", "b4"});
  const WeldedMesh mesh = welded_mesh({&low, &high}, 2), one = welded_mesh({&low}, 2);
  CHECK(mesh.points.rows() == 2 * one.points.rows());
  const EdgeCount edges(mesh);
  CHECK(edges.euler == 2);
  CHECK(edges.free == 2 * EdgeCount(one).free);
  CHECK(edges.non_manifold == 0);
  for (const auto& t : mesh.triangles) CHECK(point(mesh, t[0]).z() == point(mesh, t[2]).z());

  // Squares that meet at a corner share this vertex only.
  const SkinnedRegion beside = flat_square(3, {1, 1, 0}, {"b1", "b2", "b3", "b4"});
  const WeldedMesh touching = welded_mesh({&low, &beside}, 2);
  CHECK(touching.points.rows() == 2 * one.points.rows() - 1);
  CHECK(EdgeCount(touching).euler == 1);
}

TEST_CASE("three faces at an edge, and a wall on an inner curve, share the vertices of the curve",
          "[skinning][facets]") {
  if (!have_delaunay_mesher()) return;
  std::vector<CharacterLine> lines;
  RegionSearchOptions search;
  const auto add_wall = [&](const std::string& name, const std::string& foot, const Vec3& a,
                            const Vec3& b, const Vec3& across) {
    lines.push_back(straight(name + "1", a, a + across));
    lines.push_back(straight(name + "2", b, b + across));
    lines.push_back(straight(name + "3", a + across, b + across));
    search.specs.push_back(face_of({{foot, name + "1", name + "2", name + "3"}}));
  };
  search.max_faces_per_edge = 3;
  const int n = GENERATE(1, 3);
  SECTION("three walls") {
    lines.push_back(straight("foot", {0, 0, 0}, {0, 0, 1}));
    for (int i = 0; i < 3; ++i) {
      const double angle = 2 * pi / 3 * i;
      add_wall(std::string(1, "abc"[i]), "foot", {0, 0, 0}, {0, 0, 1},
               {std::cos(angle), std::sin(angle), 0});
    }
  }
  SECTION("a wall on a floor") {
    const Vec3 corner[] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    for (int i = 0; i < 4; ++i)
      lines.push_back(straight("f" + std::to_string(i + 1), corner[i], corner[(i + 1) % 4]));
    const Vec3 a(0.31, 0.4, 0), b(0.72, 0.57, 0);
    lines.push_back(straight("foot", a, b));
    search.specs.push_back(face_of({{"f1", "f2", "f3", "f4"}}));
    search.specs.back().inner = {"foot"};
    add_wall("a", "foot", a, b, {0, 0, 0.5});
  }
  const SurfaceModel model = model_of(lines, 0.2, search);
  const auto faces = model.skinned();
  REQUIRE(faces.size() == search.specs.size());
  const WeldedMesh mesh = welded_mesh(faces, n);
  check_consistent(mesh, faces, 1e-6);
  const EdgeCount edges(mesh);
  CHECK(edges.euler == 1);  // discs that share one arc
  // On the foot, and only there, three triangles meet.
  const std::set<Edge> foot = edges_on(curve_named(mesh, "foot"));
  CHECK(foot.size() >= static_cast<size_t>(2 * n));
  CHECK(edges.non_manifold == static_cast<int>(foot.size()));
  std::map<Edge, int> triangles_at;
  for (const auto& t : mesh.triangles)
    for (size_t i = 0; i < 3; ++i) ++triangles_at[undirected(t[i], t[(i + 1) % 3])];
  for (const Edge& edge : foot) CHECK(triangles_at.at(edge) == 3);
  REQUIRE(curve_named(mesh, "foot").polylines.size() == 1);
}

TEST_CASE("a face that meets itself along a curve is closed there", "[skinning][facets]") {
  const int n = 8, facets = GENERATE(1, 2, 3);
  const SkinnedRegion tube = mapped_square(n, {"low", "seam", "high", "seam"}, [](const Vec2& p) {
    const double a = 2 * pi * p.x(), s = std::sin(a), c = std::cos(a);
    return SurfaceJet{Vec3(c, s, 2 * p.y()), 2 * pi * Vec3(-s, c, 0),
                      Vec3(0, 0, 2),         Vec3::Zero(),
                      Vec3::Zero(),          Vec3::Zero()};
  });
  const WeldedMesh mesh = welded_mesh({&tube}, facets);
  const int around = n * facets;
  CHECK(mesh.points.rows() == around * (around + 1));
  const EdgeCount edges(mesh);
  CHECK(edges.euler == 0);
  CHECK(edges.free == 2 * around);
  CHECK(edges.same_direction == 0);
  CHECK(curve_named(mesh, "seam").polylines.size() == 1);
  CHECK_FALSE(curve_named(mesh, "seam").polylines[0].closed);
  for (const char* name : {"low", "high"}) {
    REQUIRE(curve_named(mesh, name).polylines.size() == 1);
    CHECK(curve_named(mesh, name).polylines[0].closed);
    CHECK(curve_named(mesh, name).polylines[0].vertices.size() == static_cast<size_t>(around));
  }
}

TEST_CASE("normals at the apex of a cone are unit vectors and close to those beside it",
          "[skinning][facets]") {
  // x_u = 0 along the south side, which is one point.
  const SkinnedRegion cone = mapped_square(8, {"apex", "east", "rim", "west"}, [](const Vec2& p) {
    const double a = 0.5 * pi * p.x(), v = p.y(), s = std::sin(a), c = std::cos(a);
    return SurfaceJet{v * Vec3(c, s, 1), v * 0.5 * pi * Vec3(-s, c, 0),
                      Vec3(c, s, 1),     Vec3::Zero(),
                      Vec3::Zero(),      Vec3::Zero()};
  });
  SkinnedRegion open = cone;
  open.edge_aligned.erase(open.edge_aligned.begin());  // ends of curves are one vertex
  open.boundary.clear();
  const WeldedMesh mesh = welded_mesh({&open}, 2);
  double length_error = 0, turned = 0;
  int singular = 0;
  for (int k = 0; k < mesh.normals.rows(); ++k) {
    const auto& t = mesh.triangles[static_cast<size_t>(k / 3)];
    length_error = std::max(length_error, std::abs(normal(mesh, k).norm() - 1));
    Vec3 middle = Vec3::Zero();
    for (const int v : t) middle += point(mesh, v) / 3;
    const double a = std::atan2(middle.y(), middle.x());
    turned = std::max(
        turned, (normal(mesh, k) - Vec3(-std::cos(a), -std::sin(a), 1) / -std::sqrt(2)).norm());
    singular += point(mesh, t[k % 3]).norm() < 1e-12;
  }
  CHECK(singular > 8);
  CHECK(length_error < 1e-14);
  CHECK(turned < 0.15);
}

TEST_CASE("a deformed box has no crack", "[skinning][facets]") {
  if (!have_delaunay_mesher()) return;
  const SurfaceModel model = model_of(box_lines(Vec3::Zero(), {1, 2, 3}), 0.4);
  const WeldedMesh mesh = welded_mesh(model.skinned(), 1);
  ShellMesh shells;
  shells.points = mesh.points;
  for (const auto& t : mesh.triangles) shells.add_face(t);
  const PreparedMesh prepared = prepare(shells);
  CHECK(prepared.diagnosis.components == 1);
  CHECK(prepared.diagnosis.manifold_patches == 1);
  CHECK(prepared.diagnosis.coincident_nodes == 0);
  CHECK(prepared.diagnosis.flipped_faces == 0);
  CHECK(prepared.mesh.vertex_count() == mesh.points.rows());
  CHECK(prepared.mesh.topology().boundary_loops().empty());
  CHECK(prepared.mesh.triangles() == mesh.triangles);

  DeformProblem problem;
  problem.handles = {{"top", {}}};
  for (int v = 0; v < mesh.points.rows(); ++v) {
    if (mesh.points(v, 2) < 1e-9) problem.fixed.push_back(v);
    if (mesh.points(v, 2) > 3 - 1e-9) problem.handles[0].vertices.push_back(v);
  }
  DeformEdit edit;
  HandleTransform move;
  move.about = Vec3(0.5, 1, 3);
  move.rotation_vector = Vec3(0.2, 0.1, 0.6);
  move.translation = Vec3(0.4, -0.3, 0.8);
  edit.handles = {move};
  MeshEditor editor(prepared, prepared.mesh.points(), problem);
  editor.set(edit);
  const Points& after = editor.solve_to_equilibrium();
  CHECK((after - mesh.points).rowwise().norm().maxCoeff() > 0.8);
  // The area vectors of a closed surface add up to zero. Faces keep their edges together: those on
  // curves are longer, but no gap opens.
  Vec3 sum = Vec3::Zero();
  double area = 0;
  for (const auto& t : mesh.triangles) {
    const Vec3 a = area_vector(after, t);
    sum += a;
    area += a.norm();
  }
  CHECK(area > 20);
  CHECK(sum.norm() < 1e-12 * area);
  double longest = 0;
  for (const auto& t : mesh.triangles)
    for (size_t i = 0; i < 3; ++i)
      longest = std::max(longest, (after.row(t[i]) - after.row(t[(i + 1) % 3])).norm());
  CHECK(longest < 1.2);
}

TEST_CASE("welded meshes without faces or with negative numbers of facets are rejected",
          "[skinning][facets]") {
  CHECK_THROWS_AS(welded_mesh({}), InputError);
  const SkinnedRegion square = flat_square(2, Vec3::Zero(), {"1", "2", "3", "4"});
  CHECK_THROWS_AS(welded_mesh({&square}, -1), InputError);
  // 0: as for display.
  CHECK(welded_mesh({&square}).triangles.size() == 8 * 16);
}
