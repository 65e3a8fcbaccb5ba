// SPDX-License-Identifier: MPL-2.0
// Facets of a region: nothing outside the curves, nothing missing, no folds.
#include "batten/core/cancellation.h"
#include "batten/skinning/facets/facets.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/skinning/domains/mesher.h"
#include "batten/skinning/facets/model_elements.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/error_message.h"
#include "batten/tests/support/trimmed_regions.h"

using namespace batten_test;

namespace {

std::vector<Vec2> positions(const ParametricMesh& mesh, const std::vector<Location>& points) {
  std::vector<Vec2> uv;
  for (const Location& p : points) uv.push_back(mesh.shape(p.triangle).point(p.L));
  return uv;
}

struct Count {
  double area = 0, smallest = 1e300;
  int euler = 0;
  std::set<std::pair<int, int>> rim;  // directed edges with one facet
};

Count count(const std::vector<Vec2>& uv, const std::vector<std::array<int, 3>>& facets) {
  Count c;
  std::set<std::pair<int, int>> directed;
  std::set<int> used;
  for (const auto& f : facets) {
    const double twice = cross(uv[f[1]] - uv[f[0]], uv[f[2]] - uv[f[0]]);
    c.smallest = std::min(c.smallest, twice);
    c.area += twice / 2;
    for (int i = 0; i < 3; ++i) {
      used.insert(f[i]);
      const bool once = directed.insert({f[i], f[(i + 1) % 3]}).second;
      if (!once) c.smallest = -1;
    }
  }
  int inner = 0;
  for (const auto& e : directed)
    if (directed.count({e.second, e.first}))
      ++inner;
    else
      c.rim.insert(e);
  c.euler = static_cast<int>(used.size()) - inner / 2 - static_cast<int>(c.rim.size()) +
            static_cast<int>(facets.size());
  return c;
}

/// The directed edges of the loops' polylines.
std::set<std::pair<int, int>> loop_edges(const SkinnedRegion& region,
                                         const std::vector<std::vector<std::vector<int>>>& lines) {
  std::set<std::pair<int, int>> edges;
  for (const auto& loop : region.boundary)
    for (const BoundarySegment& piece : loop) {
      const auto& chains =
          lines[static_cast<size_t>(piece.index) + (piece.kind == BoundarySegment::Kind::EdgeAligned
                                                        ? 0
                                                        : region.edge_aligned.size())];
      REQUIRE(chains.size() == 1);
      for (size_t i = 0; i + 1 < chains[0].size(); ++i)
        edges.insert(piece.reversed ? std::pair{chains[0][i + 1], chains[0][i]}
                                    : std::pair{chains[0][i], chains[0][i + 1]});
    }
  return edges;
}

}  // namespace

TEST_CASE("a mesh with holes leaves them empty", "[skinning][facets]") {
  if (!have_delaunay_mesher()) return;
  PlanarMeshInput task;
  task.edge_length = 0.1;
  task.keep_segments = GENERATE(false, true);
  const auto polygon = [&](std::vector<std::array<int, 2>>& segments, const Vec2& centre, double r,
                           int n, bool clockwise) {
    const int first = static_cast<int>(task.points.size());
    for (int i = 0; i < n; ++i) {
      const double a = (clockwise ? -2 : 2) * pi * i / n;
      task.points.push_back(centre + r * Vec2(std::cos(a), std::sin(a)));
      segments.push_back({first + i, first + (i + 1) % n});
    }
    return n * r * r / 2 * std::sin(2 * pi / n);
  };
  double area = polygon(task.outline, {0, 0}, 1, 60, false);
  task.holes.resize(2);
  area -= polygon(task.holes[0], {0.4, 0.1}, 0.3, 18, true);
  area -= polygon(task.holes[1], {-0.5, 0}, 0.01, 8, false);
  const ParametricMesh mesh = delaunay_mesh(task);
  double sum = 0, least = 1;
  int segments = 0;
  for (int t = 0; t < mesh.triangle_count(); ++t) {
    const TriangleShape shape = mesh.shape(t);
    sum += shape.area;
    double sides = 0;
    for (int i = 0; i < 3; ++i)
      sides += (shape.vertex[i] - shape.vertex[(i + 1) % 3]).squaredNorm();
    least = std::min(least, 4 * std::sqrt(3.0) * shape.area / sides);
  }
  for (const auto& e : mesh.edges()) segments += e.boundary();
  CHECK(sum == Approx(area).epsilon(1e-12));
  CHECK(mesh.vertex_count() - mesh.edge_count() + mesh.triangle_count() == -1);
  CHECK(least > 0.3);
  double mean = 0;
  for (int e = 0; e < mesh.edge_count(); ++e) mean += mesh.edge_length(e) / mesh.edge_count();
  INFO(mesh.triangle_count() << " triangles, mean edge " << mean << ", least quality " << least);
  if (task.keep_segments) CHECK(segments == 60 + 18 + 8);
  for (size_t i = 0; i < task.points.size(); ++i) CHECK(mesh.vertices()[i] == task.points[i]);
  CHECK(mesh.triangle_count() < 1500);
}

TEST_CASE("meshing stops when it is cancelled", "[skinning][facets]") {
  if (!have_delaunay_mesher()) return;
  PlanarMeshInput task;
  task.points = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  task.outline = {{0, 1}, {1, 2}, {2, 3}, {3, 0}};
  task.edge_length = 0.003;  // some 250,000 triangles
  task.keep_segments = GENERATE(false, true);
  int requested = 0;
  Progress progress;
  progress.cancelled = [&] { return ++requested == 3; };
  const ProgressScope scope(progress);
  CHECK_THROWS_AS(delaunay_mesh(task), CancelledError);
  CHECK(requested == 3);
}

TEST_CASE("facets of a disc with a hole and a rib fill it and end at its curves",
          "[skinning][facets]") {
  if (!have_delaunay_mesher()) return;
  const SkinnedRegion region = wavy_disc({});
  const DomainLoops& loops = region.surface.trim()->loops();
  double before = 0;
  for (const int n : {1, 2, 3, 4, 8}) {
    INFO("n = " << n);
    const DisplayFacets f = facets(region, n);
    const auto uv = positions(region.surface.mesh(), f.tessellation.points);
    const Count c = count(uv, f.tessellation.facets);
    CHECK(c.euler == 0);
    CHECK(c.smallest > 0);
    CHECK(c.rim == loop_edges(region, f.lines));
    const double error = loops.area() - c.area;
    if (n == 2 || n == 4 || n == 8) {
      if (n > 2) CHECK(std::log2(before / error) == Approx(2).margin(0.1));
      before = error;
    }
    // Curves: facet edges are on them; the rib between the outline and the hole is connected.
    REQUIRE(f.lines.size() == 3);
    double away = 0;
    for (size_t l = 0; l < 3; ++l) {
      REQUIRE(f.lines[l].size() == 1);
      for (const int p : f.lines[l][0])
        away = std::max(
            away, region.embedded[l].pcurve.closest_point({uv[p].x(), uv[p].y(), 0}).distance);
    }
    CHECK(away < 1e-14);
    CHECK(f.lines[0][0].front() == f.lines[0][0].back());
    const auto on = [&](size_t line, int p) {
      const auto& chain = f.lines[line][0];
      return std::count(chain.begin(), chain.end(), p) > 0;
    };
    CHECK(on(0, f.lines[2][0].front()));
    CHECK(on(1, f.lines[2][0].back()));
    // Elements at centroids.
    for (size_t k = 0; k < f.tessellation.facets.size(); ++k) {
      const auto& [a, b, d] = f.tessellation.facets[k];
      const TriangleShape shape = region.surface.mesh().shape(f.tessellation.facet_triangle[k]);
      CHECK(shape.barycentric((uv[a] + uv[b] + uv[d]) / 3).minCoeff() > -1e-12);
    }
  }
}

TEST_CASE("quadratic facets have their midpoints on the curves and are oriented correctly",
          "[skinning][facets]") {
  if (!have_delaunay_mesher()) return;
  const WavyDisc how = GENERATE(WavyDisc{}, WavyDisc{0.07, 0.3, 0.25, true},
                                WavyDisc{0.15, 0.1, 0.001, true}, WavyDisc{0.3, 0.2, 0.55, true});
  const SkinnedRegion region = wavy_disc(how);
  const QuadraticElements q = quadratic_elements(region);
  REQUIRE(q.nodes.size() == q.uv.size());
  REQUIRE(q.element.size() == q.triangles.size());
  CHECK(!q.is_element_mesh);
  const auto uv = positions(region.surface.mesh(), q.nodes);
  double off = 0;
  for (size_t i = 0; i < uv.size(); ++i) off = std::max(off, (uv[i] - q.uv[i]).norm());
  CHECK(off < 4e-15);

  std::vector<std::array<int, 3>> corners;
  std::map<std::pair<int, int>, int> middle;
  double least = 1, mean = 0;
  bool one_middle = true;
  for (size_t t = 0; t < q.triangles.size(); ++t) {
    const auto& n = q.triangles[t];
    corners.push_back({n[0], n[1], n[2]});
    const double twice = cross(uv[n[1]] - uv[n[0]], uv[n[2]] - uv[n[0]]);
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3, k = (i + 2) % 3;
      const Vec2 to_j = 4 * uv[n[3 + i]] - 3 * uv[n[i]] - uv[n[j]];
      const Vec2 to_k = 4 * uv[n[3 + k]] - 3 * uv[n[i]] - uv[n[k]];
      least = std::min(least, cross(to_j, to_k) / twice);
      const auto [at, added] = middle.try_emplace(std::minmax(n[i], n[j]), n[3 + i]);
      one_middle = one_middle && at->second == n[3 + i];
      mean += (uv[n[i]] - uv[n[j]]).norm() / (3 * static_cast<double>(q.triangles.size()));
    }
    Vec2 centre = -(uv[n[0]] + uv[n[1]] + uv[n[2]]) / 9;
    for (int i = 3; i < 6; ++i) centre += 4 * uv[n[i]] / 9;
    const TriangleShape shape = region.surface.mesh().shape(q.element[t]);
    CHECK(shape.barycentric(centre).minCoeff() > -0.2);
  }
  INFO("spacing " << how.spacing << ", " << q.triangles.size() << " triangles, mean edge " << mean);
  CHECK(least > 0.2);
  CHECK(one_middle);
  CHECK(count(uv, corners).euler == 0);
  // Mean edge of the grid's squares: 1.14 sides. Small holes lead to small triangles.
  CHECK(mean < 1.3 * how.spacing);
  if (how.hole > 0.2) CHECK(mean > 0.6 * how.spacing);

  double on_curve = 0, off_straight = 0;
  for (size_t l = 0; l < q.lines.size(); ++l) {
    const HermiteCurve& pcurve = region.embedded[l].pcurve;
    CHECK(q.lines[l].size() >= (l < 2 ? 8 : 1));
    for (const auto& [a, b, m] : q.lines[l]) {
      CHECK(middle.at(std::minmax(a, b)) == m);
      middle.erase(std::minmax(a, b));
      for (const int node : {a, b, m})
        on_curve =
            std::max(on_curve, pcurve.closest_point({q.uv[node].x(), q.uv[node].y(), 0}).distance);
      // The middle in the parameter: of a circle, in the arc.
      if (l < 2) CHECK((uv[m] - uv[a]).norm() == Approx((uv[m] - uv[b]).norm()).epsilon(1e-3));
    }
    for (size_t k = 0; k + 1 < q.lines[l].size(); ++k)
      CHECK(q.lines[l][k][1] == q.lines[l][k + 1][0]);
  }
  CHECK(on_curve < 1e-14);
  for (const auto& [ends, m] : middle)
    off_straight = std::max(off_straight, (uv[m] - (uv[ends.first] + uv[ends.second]) / 2).norm());
  CHECK(off_straight < 1e-14);
}

TEST_CASE("facets of edge-aligned faces are their elements", "[skinning][facets]") {
  SkinnedRegion region{"square",
                       interpolated(std::make_shared<const ParametricMesh>(perturbed_square(4, 3)),
                                    TriangleElement::HCT, [](const Vec2& p) { return sheet(p); }),
                       {},
                       1,
                       {},
                       {}};
  const ParametricMesh& mesh = region.surface.mesh();
  EdgeAlignedLine south;
  for (int i = 0; i <= 4; ++i) {
    south.vertices.push_back(4 - i);
    south.parameters.push_back(i);
    if (i > 0) south.edges.push_back(mesh.edge_between(5 - i, 4 - i));
  }
  region.edge_aligned.push_back(south);
  const DisplayFacets f = facets(region, 3);
  const Tessellation t = tessellate(mesh, 3);
  CHECK(f.tessellation.facets == t.facets);
  CHECK(f.tessellation.facet_triangle == t.facet_triangle);
  REQUIRE(f.tessellation.points.size() == t.points.size());
  bool same = true;
  for (size_t p = 0; p < t.points.size(); ++p)
    same = same && f.tessellation.points[p].triangle == t.points[p].triangle &&
           f.tessellation.points[p].L == t.points[p].L;
  CHECK(same);
  const auto uv = positions(mesh, t.points);
  REQUIRE(f.lines.size() == 1);
  REQUIRE(f.lines[0].size() == 1);
  REQUIRE(f.lines[0][0].size() == 13);
  for (int k = 0; k <= 12; ++k)
    CHECK((uv[f.lines[0][0][k]] - Vec2(1 - k / 12.0, 0)).norm() < 1e-15);
  const QuadraticElements q = quadratic_elements(region);
  CHECK(q.is_element_mesh);
  for (int e = 0; e < mesh.triangle_count(); ++e) {
    CHECK(q.element[e] == e);
    for (int i = 0; i < 3; ++i) {
      CHECK(q.triangles[e][i] == mesh.triangles()[e][i]);
      CHECK(q.triangles[e][3 + i] == mesh.vertex_count() + mesh.edges_of(e)[(i + 2) % 3]);
    }
  }
  REQUIRE(q.lines[0].size() == 4);
  CHECK(q.lines[0][0] == std::array<int, 3>{4, 3, mesh.vertex_count() + south.edges[0]});
}

TEST_CASE("edge-aligned runs keep their vertices when a hole is embedded, ribs may cross it",
          "[skinning][facets]") {
  if (!have_delaunay_mesher()) return;
  // The unit square with mesh-aligned sides, a hole, and a rib across the hole and a mesh-aligned
  // inner curve.
  const int n = 8;
  const auto mesh = std::make_shared<const ParametricMesh>(ParametricMesh::unit_square(n));
  std::vector<EdgeAlignedLine> edge_aligned(5);
  const int starts[5] = {0, n, (n + 1) * (n + 1) - 1, n * (n + 1), n + 1};
  const int steps[5] = {1, n + 1, -1, -(n + 1), 1};
  for (size_t r = 0; r < 5; ++r)
    for (int i = 0; i <= n; ++i) {
      edge_aligned[r].vertices.push_back(starts[r] + i * steps[r]);
      edge_aligned[r].parameters.push_back(i);
      if (i > 0)
        edge_aligned[r].edges.push_back(
            mesh->edge_between(edge_aligned[r].vertices[i - 1], edge_aligned[r].vertices[i]));
    }
  const HermiteCurve hole = circle({0.55, 0.5}, 0.2, 8);
  const auto line = [](const Vec2& from, const Vec2& to) {
    return hermite(0, 1, 2, false, [=](double t, int order) {
      const Vec2 p = order == 0 ? Vec2((1 - t) * from + t * to) : Vec2(to - from);
      return Vec3(p.x(), p.y(), 0);
    });
  };
  const std::vector<EmbeddedLine> embedded{
      line_on_sheet("hole", hole, 0.15), line_on_sheet("rib", line({0.4, 0}, {0.7, 0.95}), 0.15),
      line_on_sheet("free", line({0.1, 0.3}, {0.2, 0.9}), 0.15)};
  using Kind = BoundarySegment::Kind;
  SkinnedRegion region{
      "plate",
      interpolated(mesh, TriangleElement::HCT, [](const Vec2& p) { return sheet(p); }),
      edge_aligned,
      1,
      embedded,
      {{{Kind::EdgeAligned, 0, false},
        {Kind::EdgeAligned, 1, false},
        {Kind::EdgeAligned, 2, false},
        {Kind::EdgeAligned, 3, false}},
       {{Kind::Embedded, 0, true}}}};
  for (EdgeAlignedLine& aligned_line : region.edge_aligned) {
    const Vec3 from(mesh->vertices()[aligned_line.vertices.front()].x(),
                    mesh->vertices()[aligned_line.vertices.front()].y(), 0),
        to(mesh->vertices()[aligned_line.vertices.back()].x(),
           mesh->vertices()[aligned_line.vertices.back()].y(), 0);
    Points x(2, 3), d(2, 3);
    x << from.transpose(), to.transpose();
    d << (to - from).transpose() / n, (to - from).transpose() / n;
    aligned_line.fitted = HermiteCurve({0, static_cast<double>(n)}, x, d);
  }
  region.surface = Surface(mesh, region.surface.kind(), region.surface.dofs(),
                           std::make_shared<Trim>(*mesh, boundary_loops(region)));
  const DisplayFacets f = facets(region, 3);
  const auto uv = positions(*mesh, f.tessellation.points);
  const Count c = count(uv, f.tessellation.facets);
  CHECK(c.euler == 0);
  CHECK(c.smallest > 0);
  CHECK(c.rim == loop_edges(region, f.lines));
  CHECK(c.area == Approx(1 - pi * 0.04).epsilon(2e-3));
  REQUIRE(f.lines.size() == 8);
  for (size_t r = 0; r < 5; ++r) {
    REQUIRE(f.lines[r].size() == 1);
    for (const int v : edge_aligned[r].vertices) {
      const auto& chain = f.lines[r][0];
      CHECK(std::any_of(chain.begin(), chain.end(),
                        [&](int p) { return (uv[p] - mesh->vertices()[v]).norm() < 1e-15; }));
    }
  }
  // The rib: up to the hole, and beyond it; it intersects the curve at v = 1/8 in one point of
  // both.
  REQUIRE(f.lines[6].size() == 2);
  const auto& lower = f.lines[6][0];
  const std::set<int> aligned_line(f.lines[4][0].begin(), f.lines[4][0].end());
  std::vector<int> common;
  for (const int p : lower)
    if (aligned_line.count(p)) common.push_back(p);
  REQUIRE(common.size() == 1);
  CHECK((uv[common[0]] - Vec2(0.4 + 0.3 / 0.95 / 8, 0.125)).norm() < 1e-12);
  CHECK(std::abs((uv[lower.back()] - Vec2(0.55, 0.5)).norm() - 0.2) < 1e-3);
  CHECK((uv[f.lines[6][1].back()] - Vec2(0.7, 0.95)).norm() < 1e-15);
  REQUIRE(f.lines[7].size() == 1);

  // With inner embedded lines only, there is no trim.
  region.embedded.erase(region.embedded.begin());
  region.boundary.pop_back();
  region.surface = Surface(mesh, region.surface.kind(), region.surface.dofs());
  const DisplayFacets whole = facets(region, 2);
  const auto whole_uv = positions(*mesh, whole.tessellation.points);
  const Count all = count(whole_uv, whole.tessellation.facets);
  CHECK(all.euler == 1);
  CHECK(all.area == Approx(1).epsilon(1e-13));
  CHECK(all.rim == loop_edges(region, whole.lines));
  region.boundary.clear();
  CHECK_THAT(error_message([&] { facets(region, 2); }), Catch::Matchers::Contains("no boundary"));
}

TEST_CASE("faces that share a curve share its points", "[skinning][facets]") {
  if (!have_delaunay_mesher()) return;
  // A disc that fills the hole of another one, over another grid, with (u, v) three times as large.
  constexpr double scale = 3;
  const HermiteCurve hole = circle({0.1, 0.2}, 0.5, 8);
  const SkinnedRegion around = sheet_region({circle({0, 0}, 1, 24), hole}, {}, 0.2);
  SkinnedRegion inside = sheet_region({hole}, {}, 0.13);
  std::vector<Vec2> vertices = inside.surface.mesh().vertices();
  for (Vec2& p : vertices) p *= scale;
  const auto mesh =
      std::make_shared<const ParametricMesh>(vertices, inside.surface.mesh().triangles());
  Points dofs = inside.surface.dofs() / scale;
  for (int v = 0; v < mesh->vertex_count(); ++v) dofs.row(3 * v) *= scale;
  EmbeddedLine& rim = inside.embedded[0];
  rim.pcurve = HermiteCurve(rim.pcurve.mesh(), scale * rim.pcurve.dofs());
  inside.surface = Surface(mesh, inside.surface.kind(), dofs,
                           std::make_shared<Trim>(*mesh, boundary_loops(inside)));
  const int n = GENERATE(1, 3);
  const double length = GENERATE(0.05, 0.2);
  const DisplayFacets a = facets(around, n, length), b = facets(inside, n, length);
  const auto uv_a = positions(around.surface.mesh(), a.tessellation.points),
             uv_b = positions(*mesh, b.tessellation.points);
  const auto &of_a = a.lines[1][0], &of_b = b.lines[0][0];
  REQUIRE(of_a.size() == of_b.size());
  CHECK(static_cast<double>(of_a.size() - 1) == Approx(n * 2 * pi * 0.5 / length).epsilon(0.5));
  double apart = 0, gap = 0;
  for (size_t i = 0; i < of_a.size(); ++i) {
    apart = std::max(apart, (uv_a[of_a[i]] - uv_b[of_b[i]] / scale).norm());
    gap = std::max(gap, (around.surface.position(a.tessellation.points[of_a[i]]) -
                         inside.surface.position(b.tessellation.points[of_b[i]]))
                            .norm());
  }
  CHECK(apart < 4e-15);
  CHECK(gap < 2e-4);
  CHECK(count(uv_b, b.tessellation.facets).euler == 1);
}

TEST_CASE("edges end where neighbours ask for it", "[skinning][facets]") {
  if (!have_delaunay_mesher()) return;
  // Embedded curves: edges along them and, unless something would fold, nowhere else.
  const SkinnedRegion region =
      sheet_region({circle({0, 0}, 1, 24), circle({0, 0}, 0.4, 8)}, {}, 0.2);
  const HermiteCurve& rim = region.embedded[0].pcurve;
  SubdivisionRequest subdivision;
  subdivision.at.resize(2);
  constexpr int edges = 31;
  for (int k = 0; k <= edges; ++k)
    subdivision.at[0].push_back(rim.start() + (rim.end() - rim.start()) * std::pow(k / 31.0, 1.2));
  subdivision.at[0].back() = rim.end();
  const QuadraticElements requested = quadratic_elements(region, 0, subdivision),
                          free = quadratic_elements(region);
  REQUIRE(requested.lines[0].size() == edges);
  for (size_t k = 0; k < edges; ++k) {
    CHECK(requested.parameters[0][k][0] == subdivision.at[0][k]);
    CHECK(requested.parameters[0][k][1] == subdivision.at[0][k + 1]);
    const Vec3 there = rim.evaluate(subdivision.at[0][k]);
    CHECK((requested.uv[static_cast<size_t>(requested.lines[0][k][0])] - there.head<2>()).norm() <
          1e-14);
  }
  CHECK(requested.parameters[1] == free.parameters[1]);

  // A mesh-aligned curve keeps its vertices and gets the additional ones; without these the
  // elements are unchanged.
  const auto mesh = std::make_shared<const ParametricMesh>(ParametricMesh::unit_square(4));
  Points dofs = Points::Zero(DofMap(*mesh).count(), 3);
  for (int v = 0; v < mesh->vertex_count(); ++v)
    dofs.row(3 * v) << mesh->vertices()[v].x(), mesh->vertices()[v].y(), 0;
  SkinnedRegion square{"square", Surface(mesh, TriangleElement::HCT, dofs), {}, 1, {}, {{}}};
  const int first[] = {0, 4, 24, 20}, step[] = {1, 5, -1, -5};
  for (int s = 0; s < 4; ++s) {
    EdgeAlignedLine aligned_line;
    aligned_line.line.name = "side " + std::to_string(s);
    for (int i = 0; i <= 4; ++i) {
      aligned_line.vertices.push_back(first[s] + i * step[s]);
      aligned_line.parameters.push_back(0.25 * i);
      if (i > 0)
        aligned_line.edges.push_back(
            mesh->edge_between(aligned_line.vertices[i - 1], aligned_line.vertices[i]));
    }
    square.edge_aligned.push_back(aligned_line);
    square.boundary[0].push_back({BoundarySegment::Kind::EdgeAligned, s, false});
  }
  subdivision.at = {{}, {0, 0.25, 0.5, 0.75, 1}};
  CHECK(quadratic_elements(square, 0, subdivision).is_element_mesh);
  subdivision.at[1].insert(subdivision.at[1].begin() + 2, 0.375);
  const QuadraticElements more = quadratic_elements(square, 0, subdivision);
  CHECK_FALSE(more.is_element_mesh);
  CHECK(more.lines[0].size() == 4);
  REQUIRE(more.lines[1].size() == 5);
  CHECK(more.parameters[1][1] == std::array{0.25, 0.375});
  CHECK((more.uv[static_cast<size_t>(more.lines[1][1][1])] - Vec2(1, 0.375)).norm() < 1e-15);
}

TEST_CASE("a model's facets are those of its faces with common nodes on common curves",
          "[skinning][facets]") {
  if (!have_delaunay_mesher()) return;
  // The hole of one face, reversed, is the boundary of another one. Separately, they divide it on
  // their own.
  const SkinnedRegion around =
      sheet_region({circle({0, 0}, 1, 24), circle({0.1, 0.2}, 0.5, 8)}, {}, 0.2);
  SkinnedRegion inside = sheet_region({circle({0.1, 0.2}, 0.5, 8)}, {}, 0.06);
  EmbeddedLine& rim = inside.embedded[0];
  rim.line.name = "hole";
  rim.fitted = rim.fitted.backwards();
  rim.pcurve = rim.pcurve.backwards();
  inside.boundary[0][0].reversed = !inside.boundary[0][0].reversed;
  const ModelElements both = model_elements({&around, &inside});
  REQUIRE(both.regions.size() == 2);
  REQUIRE(both.lines.size() == 2);
  CHECK(both.lines[0].name == "rim");
  CHECK(both.lines[1].name == "hole");
  CHECK(both.lines[1].edges.size() == both.regions[0].lines[1].size());
  CHECK(both.regions[1].lines[0].size() == both.regions[0].lines[1].size());
  CHECK(both.positions.size() == both.regions[0].nodes.size() + both.regions[1].nodes.size() -
                                     2 * both.lines[1].edges.size());
  std::map<std::array<int, 3>, int> edges;
  for (size_t r = 0; r < 2; ++r)
    for (const auto& t : both.regions[r].triangles)
      for (size_t i = 0; i < 3; ++i) {
        const int a = both.node[r][t[i]], b = both.node[r][t[(i + 1) % 3]];
        ++edges[{std::min(a, b), std::max(a, b), both.node[r][t[3 + i]]}];
      }
  int rims = 0;
  for (const auto& [edge, count] : edges) {
    CHECK(count <= 2);
    rims += count == 1;
  }
  CHECK(rims == static_cast<int>(both.lines[0].edges.size()));
  for (const auto& edge : both.lines[1].edges)
    for (const int node : edge) {
      const Vec3& p = both.positions[static_cast<size_t>(node)];
      CHECK(std::abs(around.embedded[1].fitted.closest_point(p).distance) < 1e-12);
    }

  // A single region: the same as quadratic_elements().
  const ModelElements one = model_elements({&around});
  const QuadraticElements same = quadratic_elements(around);
  CHECK(one.regions[0].triangles == same.triangles);
  CHECK(one.regions[0].uv == same.uv);
  for (size_t i = 0; i < one.node[0].size(); ++i) CHECK(one.node[0][i] == static_cast<int>(i));
}

TEST_CASE("facets of random outlines with holes never fold", "[skinning][facets]") {
  if (!have_delaunay_mesher()) return;
  Random random(20);
  // r(a) = r0 (1 + Σ c_k cos(k a + p_k)), represented by cubics.
  const auto wobble = [&](const Vec2& centre, double r0, double strength, int segments) {
    std::array<double, 5> c, p;
    for (size_t k = 0; k < 5; ++k) {
      c[k] = strength * random() / static_cast<double>(k + 2);
      p[k] = random.between(0, 2 * pi);
    }
    return hermite(0, 2 * pi, segments, true, [=](double a, int order) {
      double r = r0, d = 0;
      for (size_t k = 0; k < 5; ++k) {
        const double m = static_cast<double>(k + 2);
        r += r0 * c[k] * std::cos(m * a + p[k]);
        d -= r0 * c[k] * m * std::sin(m * a + p[k]);
      }
      const Vec2 e(std::cos(a), std::sin(a)), s(-e.y(), e.x());
      const Vec2 x = order == 0 ? Vec2(centre + r * e) : Vec2(d * e + r * s);
      return Vec3(x.x(), x.y(), 0);
    });
  };
  for (int trial = 0; trial < 50; ++trial) {
    INFO("trial " << trial);
    std::vector<HermiteCurve> closed{wobble({0, 0}, 1, 0.45, 32)};
    const int holes = trial % 4;
    for (int h = 0; h < holes; ++h) {
      const double a = 2 * pi * h / holes + random();
      const double r = h == 2 ? 0.003 : random.between(0.03, 0.16);
      closed.push_back(wobble(0.33 * Vec2(std::cos(a), std::sin(a)), r, 0.4, 16));
    }
    const SkinnedRegion region = sheet_region(closed, {}, random.between(0.08, 0.4));
    for (const int n : {1, 2, 5}) {
      const DisplayFacets f = facets(region, n);
      const auto uv = positions(region.surface.mesh(), f.tessellation.points);
      const Count c = count(uv, f.tessellation.facets);
      CHECK(c.smallest > 0);
      CHECK(c.euler == 1 - holes);
      CHECK(c.rim == loop_edges(region, f.lines));
      if (n == 5) CHECK(c.area == Approx(region.surface.trim()->loops().area()).epsilon(2e-3));
    }
  }
}

TEST_CASE("facets of faces with corners and cusps, and curves that touch wrongly",
          "[skinning][facets]") {
  if (!have_delaunay_mesher()) return;
  // A lens between two arcs that meet at `angle`, each a separate curve.
  const auto lens = [](double angle) {
    const auto arc = [&](double side) {
      return hermite(0, 1, 4, false, [=](double t, int order) {
        const double k = side * std::tan(angle / 2);
        return order == 0 ? Vec3(t, k * t * (1 - t), 0) : Vec3(1, k * (1 - 2 * t), 0);
      });
    };
    const HermiteCurve low = arc(-1), high = arc(1);
    const DomainLoops domain({{low, high.backwards()}});
    const EmbeddedGrid grid(squares({-0.11, -0.53}, 0.1, 13, 11), domain);
    const Surface plain =
        interpolated(grid.mesh, TriangleElement::HCT, [](const Vec2& p) { return sheet(p); });
    return SkinnedRegion{"lens",
                         Surface(grid.mesh, plain.kind(), plain.dofs(), grid.trim),
                         {},
                         1,
                         {line_on_sheet("low", low, 0.15), line_on_sheet("high", high, 0.15)},
                         {{{BoundarySegment::Kind::Embedded, 0, false},
                           {BoundarySegment::Kind::Embedded, 1, true}}}};
  };
  for (const double degrees : {90.0, 30.0, 5.0}) {
    INFO(degrees << " degrees");
    const SkinnedRegion region = lens(degrees * pi / 180);
    const DisplayFacets f = facets(region, 3);
    const auto uv = positions(region.surface.mesh(), f.tessellation.points);
    const Count c = count(uv, f.tessellation.facets);
    CHECK(c.euler == 1);
    CHECK(c.smallest > 0);
    CHECK(c.rim == loop_edges(region, f.lines));
    CHECK(c.area == Approx(region.surface.trim()->loops().area()).epsilon(1e-2));
  }
  // An outline that passes through a hole.
  SkinnedRegion wrong = wavy_disc({});
  wrong.embedded[1] = line_on_sheet("hole", circle({0.9, 0}, 0.25, 8), 0.15);
  CHECK_THAT(error_message([&] { facets(wrong, 1); }), Catch::Matchers::Contains("'rim'") &&
                                                           Catch::Matchers::Contains("'hole'") &&
                                                           Catch::Matchers::Contains("intersect"));
}
