#include "batten/skinning/facets/facets.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include "batten/core/errors.h"
#include "batten/fem/triangle_locator.h"
#include "batten/skinning/facets/facet_mesh.h"
#include "batten/skinning/facets/line_subdivision.h"

namespace batten {
namespace {

bool has_own_mesh(const SkinnedRegion& region) {
  return region.surface.trim() || !region.embedded.empty();
}

/// Whether an edge has to end on a run where the elements have no vertex.
bool requests_more(const SkinnedRegion& region, const SubdivisionRequest& requested) {
  for (size_t r = 0; r < std::min(requested.at.size(), region.edge_aligned.size()); ++r) {
    const std::vector<double>& has = region.edge_aligned[r].parameters;
    const double same = kParameterTolerance * (has.back() - has.front());
    for (const double t : requested.at[r])
      if (std::none_of(has.begin(), has.end(), [&](double u) { return std::abs(u - t) <= same; }))
        return true;
  }
  return false;
}

/// Display points, those on each edge from its lower end to its higher one, and lines as chains of
/// directed edges.
struct SampledMesh {
  Tessellation tessellation;
  std::vector<Vec2> uv;
  std::vector<std::vector<int>> edge_points;
  struct Link {
    int edge, from, to;
    double t0, t1;
  };
  std::vector<std::vector<Link>> lines;
  std::shared_ptr<const ParametricMesh> mesh;
  bool is_element_mesh = true;
};

SampledMesh sample_mesh(const SkinnedRegion& region, int n, double edge_length,
                        const SubdivisionRequest& requested = {}) {
  SampledMesh result;
  const Surface& surface = region.surface;
  std::optional<FacetMesh> own;
  if (has_own_mesh(region) || requests_more(region, requested))
    own = facet_mesh(region, edge_length, requested);
  result.is_element_mesh = !own;
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
    for (const EdgeAlignedLine& aligned_line : region.edge_aligned) {
      result.lines.emplace_back();
      for (size_t k = 0; k < aligned_line.edges.size(); ++k)
        result.lines.back().push_back({aligned_line.edges[k], aligned_line.vertices[k],
                                       aligned_line.vertices[k + 1], aligned_line.parameters[k],
                                       aligned_line.parameters[k + 1]});
    }
    return result;
  }
  const size_t lines = region.edge_aligned.size() + region.embedded.size();
  for (size_t l = 0; l < lines; ++l) {
    const auto& list = own->edges_of_line[l];
    result.lines.emplace_back();
    for (const int p : list) {
      const ConstrainedEdge& piece = own->constrained_edges[p];
      result.lines.back().push_back(
          {mesh.edge_between(piece.a, piece.b), piece.a, piece.b, piece.t0, piece.t1});
    }
  }
  const TriangleLocator locator(surface.mesh());
  for (Location& where : points) {
    result.uv.push_back(own->map_point(where));
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

double mean_facet_length(const std::vector<const SkinnedRegion*>& regions) {
  double sum = 0;
  for (const auto* region : regions) sum += facet_length(*region);
  return sum / static_cast<double>(regions.size());
}

int display_facets_per_edge(const std::vector<const SkinnedRegion*>& regions) {
  constexpr double max_facets = 400'000;
  double triangles = 0;
  for (const auto* region : regions) triangles += region->surface.mesh().triangle_count();
  return std::clamp(static_cast<int>(std::sqrt(max_facets / triangles)), 1, 4);
}

QuadraticElements quadratic_elements(const SkinnedRegion& region, double edge_length,
                                     const SubdivisionRequest& requested) {
  SampledMesh halves = sample_mesh(region, 2, edge_length, requested);
  const ParametricMesh& mesh = *halves.mesh;
  const auto middle = [&](int edge) { return halves.edge_points[edge][1]; };
  QuadraticElements result;
  result.is_element_mesh = halves.is_element_mesh;
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
  SampledMesh all = sample_mesh(region, n, edge_length);
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

std::string facet_error(const SkinnedRegion& region) {
  if (region.embedded.empty()) return "";
  try {
    quadratic_elements(region);
  } catch (const InputError& e) {
    return e.what();
  }
  return "";
}

}  // namespace batten
