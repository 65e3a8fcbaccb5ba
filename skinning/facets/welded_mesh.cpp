// SPDX-License-Identifier: MPL-2.0
#include "batten/skinning/facets/welded_mesh.h"

#include <algorithm>
#include <span>
#include <utility>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/parallel.h"
#include "batten/skinning/facets/model_elements.h"

namespace batten {
namespace {

/// Facets of one face, with the positions and area vectors x_u × x_v of their vertices.
struct FaceFacets {
  DisplayFacets display;
  std::vector<Vec3> positions, area_vectors;
};

FaceFacets face_facets(const SkinnedRegion& region, int n, double edge_length,
                       const SubdivisionRequest& requested) {
  FaceFacets face;
  face.display = facets(region, n, edge_length, requested);
  for (const Location& where : face.display.tessellation.points) {
    face.positions.push_back(region.surface.position(where));
    face.area_vectors.push_back(region.surface.area_vector(where));
  }
  return face;
}

/// Unit normals at the corners of a facet. `area_vectors`: those of the surface at the corners.
/// `flat`: area vector of the flat triangle.
std::array<Vec3, 3> corner_normals(const std::array<Vec3, 3>& area_vectors, const Vec3& flat) {
  constexpr double kSingular = 1e-6;  // of the largest Jacobian; as SkinQuality::singular_nodes
  double largest = 0;
  for (const Vec3& a : area_vectors) largest = std::max(largest, a.norm());
  const Vec3 mean = largest > 0 ? Vec3(area_vectors[0] + area_vectors[1] + area_vectors[2]) : flat;
  std::array<Vec3, 3> normals;
  for (size_t c = 0; c < 3; ++c) {
    const bool singular = !(area_vectors[c].norm() > kSingular * largest);
    normals[c] = (singular ? mean : area_vectors[c]).normalized();
  }
  return normals;
}

/// Appends `next` to `chain`, without repeating the common vertex.
void append_chain(std::vector<int>& chain, const std::vector<int>& next) {
  chain.insert(chain.end(), next.begin() + 1, next.end());
}

/// Extends `chain` by `next`, reversed if necessary, at a common end. Keeps the direction of
/// `chain`. Returns false, and changes nothing, if there is no common end.
bool extend_chain(std::vector<int>& chain, std::vector<int>& next) {
  if (next.back() == chain.back() || next.front() == chain.front())
    std::reverse(next.begin(), next.end());
  if (next.front() == chain.back()) {
    append_chain(chain, next);
    return true;
  }
  if (next.back() != chain.front()) return false;
  append_chain(next, chain);
  chain.swap(next);
  return true;
}

/// Joins the parts of a curve at their common ends. `parts`: the vertices of each part.
std::vector<std::vector<int>> joined_chains(const std::vector<std::vector<int>>& parts) {
  std::vector<std::vector<int>> chains;
  for (const std::vector<int>& part : parts)  // usually in order along the curve
    if (!chains.empty() && chains.back().back() == part.front())
      append_chain(chains.back(), part);
    else
      chains.push_back(part);
  for (size_t i = 0; i < chains.size(); ++i)
    for (size_t j = i + 1; j < chains.size();)
      if (extend_chain(chains[i], chains[j])) {
        chains.erase(chains.begin() + static_cast<long>(j));
        j = i + 1;
      } else {
        ++j;
      }
  return chains;
}

class ModelWelder {
 public:
  ModelWelder(const std::vector<const SkinnedRegion*>& regions, int n, double edge_length)
      : regions_(regions),
        n_(static_cast<size_t>(n)),
        elements_(model_elements(regions, edge_length)),
        faces_(regions.size()),
        vertex_of_node_(elements_.positions.size(), -1),
        inside_edge_(elements_.positions.size()) {
    parallel_for(isize(regions), [&](int r) {
      const auto i = static_cast<size_t>(r);
      faces_[i] = face_facets(*regions[i], n, edge_length, elements_.requests[i]);
    });
  }

  WeldedMesh make() {
    for (size_t r = 0; r < regions_.size(); ++r) weld(r);
    result_.points.resize(isize(positions_), 3);
    for (int v = 0; v < isize(positions_); ++v) result_.points.row(v) = positions_[v].transpose();
    result_.normals.resize(isize(normals_), 3);
    for (int k = 0; k < isize(normals_); ++k) result_.normals.row(k) = normals_[k].transpose();
    list_curves();
    return std::move(result_);
  }

 private:
  /// The vertices inside a triangle edge on a curve, from the end with the lower node number.
  struct InsideEdge {
    std::vector<int> vertices;
    std::vector<Vec3> on_curve;  ///< points on the curve, unless it is mesh-aligned in a face
  };

  int add(const Vec3& position) {
    positions_.push_back(position);
    return isize(positions_) - 1;
  }

  /// Appends the facets of a face, welded to those of the previous faces.
  void weld(size_t r) {
    const FaceFacets& face = faces_[r];
    std::vector<int> vertex(face.positions.size(), -1);  // number in the model
    weld_corners(r, vertex);
    for (size_t l = 0; l < face.display.lines.size(); ++l) weld_line(r, l, vertex);
    for (size_t i = 0; i < vertex.size(); ++i)
      if (vertex[i] < 0) vertex[i] = add(face.positions[i]);
    for (const auto& [a, b, c] : face.display.tessellation.facets) {
      const std::array<int, 3> triangle{vertex[a], vertex[b], vertex[c]};
      const Vec3 &p = positions_[triangle[0]], &q = positions_[triangle[1]],
                 &s = positions_[triangle[2]];
      result_.triangles.push_back(triangle);
      result_.region.push_back(static_cast<int>(r));
      const auto normals = corner_normals(
          {face.area_vectors[a], face.area_vectors[b], face.area_vectors[c]}, (q - p).cross(s - p));
      normals_.insert(normals_.end(), normals.begin(), normals.end());
    }
  }

  /// Numbers the corners of the triangles of a face. They are nodes of the model.
  void weld_corners(size_t r, std::vector<int>& vertex) {
    for (const auto& triangle : elements_.regions[r].triangles)
      for (size_t i = 0; i < 3; ++i) {
        const int node = elements_.node[r][triangle[i]];
        int& number = vertex_of_node_[node];
        if (number < 0) number = add(elements_.positions[node]);
        vertex[triangle[i]] = number;
      }
  }

  /// Numbers the vertices inside the edges on line `l` of a face.
  void weld_line(size_t r, size_t l, std::vector<int>& vertex) {
    size_t e = 0;  // the chains run through the edges in their order, n facets on each edge
    for (const std::vector<int>& chain : faces_[r].display.lines[l])
      for (size_t first = 0; first + 1 < chain.size(); first += n_, ++e)
        weld_edge(r, l, e, {chain.data() + first + 1, n_ - 1}, vertex);
  }

  void weld_edge(size_t r, size_t l, size_t e, std::span<const int> inside,
                 std::vector<int>& vertex) {
    const SkinnedRegion& region = *regions_[r];
    const size_t aligned_lines = region.edge_aligned.size();
    const bool aligned = l < aligned_lines;
    const auto& [a, b, middle] = elements_.regions[r].lines[l][e];
    const auto& [t0, t1] = elements_.regions[r].parameters[l][e];
    const auto& node = elements_.node[r];
    InsideEdge& edge = inside_edge_[node[middle]];
    const bool first_side = edge.vertices.empty(), moves = !first_side && !edge.on_curve.empty();
    if (first_side) {
      edge.vertices.assign(n_ - 1, -1);
      edge.on_curve.assign(aligned ? 0 : n_ - 1, Vec3::Zero());
    }
    for (size_t j = 0; j < inside.size(); ++j) {
      const size_t k = node[a] < node[b] ? j : inside.size() - 1 - j;
      const Vec3& on_surface = faces_[r].positions[inside[j]];
      if (first_side) {
        edge.vertices[k] = add(on_surface);
        const double t = t0 + static_cast<double>(j + 1) / static_cast<double>(n_) * (t1 - t0);
        if (!aligned) edge.on_curve[k] = region.embedded[l - aligned_lines].fitted.evaluate(t);
      }
      vertex[inside[j]] = edge.vertices[k];
      if (moves) positions_[edge.vertices[k]] = aligned ? on_surface : edge.on_curve[k];
    }
    if (aligned) edge.on_curve.clear();
  }

  void list_curves() {
    for (const ModelElements::Line& line : elements_.lines) {
      WeldedCurve& curve = result_.curves.emplace_back();
      curve.name = line.name;
      std::vector<std::vector<int>> parts;
      for (const auto& edge : line.edges) parts.push_back(vertices_of(edge));
      for (std::vector<int>& chain : joined_chains(parts)) {
        const bool closed = chain.front() == chain.back();
        if (closed) chain.pop_back();
        curve.polylines.push_back({std::move(chain), closed});
      }
    }
  }

  /// All vertices on an edge of a curve, given by its nodes (first end, second end, midpoint).
  std::vector<int> vertices_of(const std::array<int, 3>& edge) const {
    const auto& [a, b, middle] = edge;
    std::vector<int> all = inside_edge_[middle].vertices;
    if (a > b) std::reverse(all.begin(), all.end());
    all.insert(all.begin(), vertex_of_node_[a]);
    all.push_back(vertex_of_node_[b]);
    return all;
  }

  const std::vector<const SkinnedRegion*>& regions_;
  size_t n_;
  ModelElements elements_;
  std::vector<FaceFacets> faces_;
  std::vector<int> vertex_of_node_;      // vertex at a node of the model; -1: none
  std::vector<InsideEdge> inside_edge_;  // for the midpoint node of each edge on a curve
  std::vector<Vec3> positions_, normals_;
  WeldedMesh result_;
};

}  // namespace

WeldedMesh welded_mesh(const std::vector<const SkinnedRegion*>& regions, int facets_per_edge,
                       double edge_length) {
  if (facets_per_edge < 0)
    throw InputError("welded mesh: found " + std::to_string(facets_per_edge) +
                     " facets per edge, expected 0 or more");
  if (regions.empty()) throw InputError("welded mesh: found no face, expected one or more");
  const int n = facets_per_edge > 0 ? facets_per_edge : display_facets_per_edge(regions);
  return ModelWelder(regions, n, edge_length > 0 ? edge_length : mean_facet_length(regions)).make();
}

}  // namespace batten
