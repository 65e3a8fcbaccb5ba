// SPDX-License-Identifier: MPL-2.0
// Evaluates the vertex selections of a scene.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "batten/io/meshes/mesh_file.h"
#include "batten/io/scene/deform_scene.h"
#include "batten/mesh/prepared_mesh.h"

namespace batten {

/// Evaluates selections, cuts and proposed features of a scene on demand, on the undeformed mesh,
/// and caches them. All functions throw InputError, with the location of the name, for an unknown
/// name (with the nearest as a suggestion), an empty selection, or circular selections.
class VertexSelector {
 public:
  VertexSelector(const SceneSelections& scene, const MeshFile& file, const TriangleMesh& mesh);

  /// Vertices of a selection, cut or proposal, as ascending node indices of the file.
  std::vector<int> of(const LocatedString& name);
  /// Union of the vertices of several names, ascending; '*' is a wildcard.
  std::vector<int> of(const std::vector<LocatedString>& names);
  /// All names that match a wildcard, except selections that are being evaluated.
  std::vector<LocatedString> matching(const LocatedString& word);
  /// The proposal with this name, or nullptr.
  const DetectedFeature* proposal(const std::string& name);
  /// All proposed features.
  const std::vector<DetectedFeature>& proposals();
  /// The vertex of a node number. Throws InputError with `location` if there is none.
  int vertex_of_label(long label, const SourceLocation& location) const;
  /// The vertices of a line, in order: the shortest path along edges through the vertices of the
  /// rule. Creases have reduced length, so that the path follows them.
  std::vector<int> path(const LineSpec& rule);

 private:
  // Vertices that meet all conditions of a rule; the following functions evaluate one condition
  // each.
  std::vector<int> select(const SelectionSpec& rule);
  std::vector<int> loop_of(const SelectionSpec& rule) const;
  std::vector<int> part_of(const SelectionSpec& rule) const;
  std::vector<int> within_distance(const SelectionSpec& rule);
  std::vector<int> listed_vertices(const SelectionSpec& rule) const;
  std::vector<int> cut(const CutSpec& rule);
  std::vector<int> stroke(const CutSpec& rule);
  std::vector<int> salient_region(const SelectionSpec& rule);
  std::vector<std::string> names();

  const SceneSelections& scene_;
  const MeshFile& file_;
  const TriangleMesh& mesh_;
  std::map<std::string, std::vector<int>> found_;
  std::vector<std::string> in_progress_;
  std::vector<DetectedFeature> proposals_;
  bool proposed_ = false;
  VecX saliency_;  // computed on demand
};

}  // namespace batten
