#include "batten/skinning/facets/facets.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include "batten/core/errors.h"
#include "batten/fem/triangle_locator.h"
#include "batten/skinning/facets/facet_mesh.h"
#include "batten/skinning/facets/facet_stops.h"

namespace batten {
namespace {

bool has_own_mesh(const SkinnedRegion& region) {
  return region.surface.trim() || !region.embedded.empty();
}

/// Whether an edge has to end on a run where the elements have no vertex.
bool asks_for_more(const SkinnedRegion& region, const LineStops& asked) {
  for (size_t r = 0; r < std::min(asked.at.size(), region.runs.size()); ++r) {
    const std::vector<double>& has = region.runs[r].parameters;
    const double same = kSameParameter * (has.back() - has.front());
    for (const double t : asked.at[r])
      if (std::none_of(has.begin(), has.end(), [&](double u) { return std::abs(u - t) <= same; }))
        return true;
  }
  return false;
}

/// Display points, those on each edge from its lower end to its higher one, and lines as chains of
/// directed edges.
struct Pattern {
  Tessellation tessellation;
  std::vector<Vec2> uv;
  std::vector<std::vector<int>> edge_points;
  struct Link {
    int edge, from, to;
    double t0, t1;
  };
  std::vector<std::vector<Link>> lines;
  std::shared_ptr<const ParametricMesh> mesh;
  bool of_elements = true;
};

Pattern pattern(const SkinnedRegion& region, int n, double edge_length,
                const LineStops& asked = {}) {
  Pattern result;
  const Surface& surface = region.surface;
  std::optional<FacetMesh> own;
  if (has_own_mesh(region) || asks_for_more(region, asked))
    own = facet_mesh(region, edge_length, asked);
  result.of_elements = !own;
  result.mesh = own ? own->mesh : surface.shared_mesh();
  const ParametricMesh& mesh = *result.mesh;

  result.tessellation = tessellate(mesh, n);
  auto& points = result.tessellation.points;
  for (const auto& e : mesh.edges()) result.edge_points.push_back({e.low});
  // After the vertices come the points inside edges, from the lower end, and inside triangles.
  for (size_t p = static_cast<size_t>(mesh.vertex_count()); p < points.size(); ++p)
    for (int i = 0; i < 3; ++i)
      if (points[p].L[i] == 0)
        result.edge_points[mesh.edges_of(points[p].triangle)[i]].push_back(static_cast<int>(p));
  for (int e = 0; e < mesh.edge_count(); ++e) result.edge_points[e].push_back(mesh.edges()[e].high);

  if (!own) {
    for (const Location& where : points)
      result.uv.push_back(mesh.shape(where.triangle).point(where.L));
    for (const LineRun& run : region.runs) {
      result.lines.emplace_back();
      for (size_t k = 0; k < run.edges.size(); ++k)
        result.lines.back().push_back({run.edges[k], run.vertices[k], run.vertices[k + 1],
                                       run.parameters[k], run.parameters[k + 1]});
    }
    return result;
  }
  const size_t lines = region.runs.size() + region.embedded.size();
  for (size_t l = 0; l < lines; ++l) {
    const auto& list = own->piece_lists[l];
    result.lines.emplace_back();
    for (const int p : list) {
      const FacetPiece& piece = own->pieces[p];
      result.lines.back().push_back(
          {mesh.edge_between(piece.a, piece.b), piece.a, piece.b, piece.t0, piece.t1});
    }
  }
  const TriangleLocator locator(surface.mesh());
  for (Location& where : points) {
    result.uv.push_back(own->image(where));
    where = locator.locate(result.uv.back());
  }
  for (size_t f = 0; f < result.tessellation.facets.size(); ++f) {
    const auto& [a, b, c] = result.tessellation.facets[f];
    const Vec2& first = result.uv[a];
    result.tessellation.facet_triangle[f] =
        locator
            .locate((first + mesh.image_near(result.uv[b], first) +
                     mesh.image_near(result.uv[c], first)) /
                    3)
            .triangle;
  }
  return result;
}

}  // namespace

double facet_length(const SkinnedRegion& region) { return mean_edge(region.surface).space; }

double common_facet_length(const std::vector<const SkinnedRegion*>& regions) {
  double sum = 0;
  for (const auto* region : regions) sum += facet_length(*region);
  return sum / static_cast<double>(regions.size());
}

int shown_facets_per_edge(const std::vector<const SkinnedRegion*>& regions) {
  constexpr double most_facets = 400'000;
  double triangles = 0;
  for (const auto* region : regions) triangles += region->surface.mesh().triangle_count();
  return std::clamp(static_cast<int>(std::sqrt(most_facets / triangles)), 1, 4);
}

QuadraticFacets quadratic_facets(const SkinnedRegion& region, double edge_length,
                                 const LineStops& asked) {
  Pattern halves = pattern(region, 2, edge_length, asked);
  const ParametricMesh& mesh = *halves.mesh;
  const auto middle = [&](int edge) { return halves.edge_points[edge][1]; };
  QuadraticFacets result;
  result.of_elements = halves.of_elements;
  for (int t = 0; t < mesh.triangle_count(); ++t) {
    const auto &v = mesh.triangles()[t], &e = mesh.edges_of(t);
    result.triangles.push_back({v[0], v[1], v[2], middle(e[2]), middle(e[0]), middle(e[1])});
    // Of four facets, the one without a corner is the middle one.
    for (int f = 4 * t; f < 4 * t + 4; ++f) {
      const auto& corners = halves.tessellation.facets[f];
      if (*std::min_element(corners.begin(), corners.end()) >= mesh.vertex_count())
        result.element.push_back(halves.tessellation.facet_triangle[f]);
    }
  }
  for (const auto& links : halves.lines) {
    result.lines.emplace_back();
    result.parameters.emplace_back();
    for (const auto& link : links) {
      result.lines.back().push_back({link.from, link.to, middle(link.edge)});
      result.parameters.back().push_back({link.t0, link.t1});
    }
  }
  result.nodes = std::move(halves.tessellation.points);
  result.uv = std::move(halves.uv);
  return result;
}

DisplayFacets facets(const SkinnedRegion& region, int n, double edge_length) {
  Pattern all = pattern(region, n, edge_length);
  DisplayFacets result;
  for (const auto& links : all.lines) {
    auto& chains = result.lines.emplace_back();
    for (const auto& link : links) {
      std::vector<int> piece = all.edge_points[link.edge];
      if (piece.front() != link.from) std::reverse(piece.begin(), piece.end());
      if (chains.empty() || chains.back().back() != link.from)
        chains.push_back(piece);
      else
        chains.back().insert(chains.back().end(), piece.begin() + 1, piece.end());
    }
  }
  result.tessellation = std::move(all.tessellation);
  return result;
}

std::string why_no_facets(const SkinnedRegion& region) {
  if (region.embedded.empty()) return "";
  try {
    quadratic_facets(region);
  } catch (const InputError& e) {
    return e.what();
  }
  return "";
}

}  // namespace batten
