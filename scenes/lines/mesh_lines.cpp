// SPDX-License-Identifier: MPL-2.0
#include "batten/scenes/lines/mesh_lines.h"

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/mesh/features/feature_lines.h"

namespace batten {
namespace {

/// Region specification of a patch; empty for patches without a border, or with a line that occurs
/// twice in it. The region search handles these.
std::optional<RegionSpec> spec_of(const FeaturePatch& patch, const std::vector<SceneLine>& lines) {
  RegionSpec spec;
  std::set<int> used;
  for (const auto& loop : patch.loops) {
    auto& names = spec.loops.emplace_back();
    for (const int l : loop) {
      if (!used.insert(l).second) return {};
      names.push_back(lines[l].name);
    }
  }
  if (spec.loops.empty()) return {};
  for (const int l : patch.inner) spec.inner.push_back(lines[l].name);
  spec.annulus = patch.loops.size() == 2 && !patch.flat && patch.loops[0].size() == 1 &&
                 patch.loops[1].size() == 1;
  return spec;
}

/// The edge between two vertices; edges are sorted by their vertices.
int edge_between(int low, int high, const MeshTopology& topology) {
  const auto& edges = topology.edges();
  const auto at = std::lower_bound(
      edges.begin(), edges.end(), std::pair(low, high),
      [](const auto& edge, const auto& wanted) { return std::pair(edge.low, edge.high) < wanted; });
  return static_cast<int>(at - edges.begin());
}

/// The edges between nodes of a set, if they are a chain: no node has more than two of them.
/// `nodes`: ascending.
std::vector<int> chain_of(const std::vector<int>& nodes, const MeshTopology& topology) {
  std::vector<int> edges;
  std::map<int, int> count;
  for (const int node : nodes)
    for (const int low : topology.coincident_vertices(node))
      for (const int high : topology.neighbours(low)) {
        const int other = topology.node_of(high);
        if (high < low || !std::binary_search(nodes.begin(), nodes.end(), other)) continue;
        if (++count[node] > 2 || ++count[other] > 2) return {};
        edges.push_back(edge_between(low, high, topology));
      }
  return count.size() == nodes.size() ? sorted_unique(std::move(edges)) : std::vector<int>();
}

/// Names of lines and faces, from the sets of the mesh.
class SetNames {
 public:
  explicit SetNames(const std::vector<MeshSet>& sets) : sets_(sets) {}

  /// The name of the smallest set with all `members`, or `otherwise`. `most`: size of the largest
  /// set that counts. A name that was given before gets a number.
  std::string of(std::vector<int> members, std::vector<int> MeshSet::*list, size_t most,
                 const std::string& otherwise) {
    members = sorted_unique(std::move(members));
    const MeshSet* best = nullptr;
    for (const MeshSet& set : sets_) {
      const std::vector<int>& all = set.*list;
      if (all.empty() || all.size() > most || (best && all.size() >= (best->*list).size()))
        continue;
      if (std::includes(all.begin(), all.end(), members.begin(), members.end())) best = &set;
    }
    const std::string& first = best ? best->name : otherwise;
    std::string name = first;
    for (int number = 2; !given_.insert(name).second; ++number)
      name = first + " " + std::to_string(number);
    return name;
  }

 private:
  const std::vector<MeshSet>& sets_;
  std::set<std::string> given_;
};

SceneLine line_of(const FeatureLine& feature, const TriangleMesh& mesh) {
  SceneLine line;
  for (const int v : feature.vertices) line.points.push_back(mesh.point(v));
  if (feature.closed) line.points.push_back(line.points.front());
  line.corners.emplace();  // lines end at their corners
  return line;
}

}  // namespace

void add_mesh_lines(Scene& scene, const PreparedMesh& prepared, const std::vector<MeshSet>& sets) {
  const TriangleMesh& mesh = prepared.mesh;
  const MeshTopology& topology = mesh.topology();
  scene.network.tolerance = kExactLineTolerance * mesh.size();
  FeatureLineOptions options;
  for (const MeshSet& set : sets) {
    const std::vector<int> edges = chain_of(set.nodes, topology);
    options.given_edges.insert(options.given_edges.end(), edges.begin(), edges.end());
  }
  const FeatureLines found = feature_lines(mesh, options);
  if (found.lines.empty())
    throw InputError(
        "found no crease and no free edge in the mesh, expected the curves to keep (--curves)");
  SetNames line_names(sets), face_names(sets);
  int creases = 0, free_edges = 0;
  for (const FeatureLine& feature : found.lines) {
    SceneLine line = line_of(feature, mesh);
    const bool is_free = feature.kind == FeatureLine::Kind::Boundary;
    const std::string number = std::to_string(is_free ? ++free_edges : ++creases);
    std::vector<int> nodes;
    for (const int v : feature.vertices) nodes.push_back(topology.node_of(v));
    constexpr size_t largest = 4;  // a set of many lines names none of them
    const size_t most = largest * nodes.size();
    line.name = line_names.of(std::move(nodes), &MeshSet::nodes, most,
                              (is_free ? "free edge " : "crease ") + number);
    if (feature.kind == FeatureLine::Kind::Crease)
      scene.network.joins.push_back({line.name, JoinSpec::Kind::Crease, ""});
    scene.lines.push_back(std::move(line));
  }
  const auto faces = prepared.face_of_triangle.empty()
                         ? 0
                         : 1 + *std::max_element(prepared.face_of_triangle.begin(),
                                                 prepared.face_of_triangle.end());
  for (int p = 0; p < isize(found.patches); ++p)
    if (auto spec = spec_of(found.patches[p], scene.lines)) {
      std::vector<int> members;
      for (const int t : found.patches[p].triangles)
        members.push_back(prepared.face_of_triangle[t]);
      // A set of all faces names none of them.
      spec->name = face_names.of(std::move(members), &MeshSet::faces,
                                 static_cast<size_t>(std::max(faces - 1, 0)),
                                 "patch " + std::to_string(p + 1));
      scene.network.regions.push_back(std::move(*spec));
    }
}

}  // namespace batten
