// Finds the vertices of a mesh that the names of a deform scene mean.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "batten/io/meshes/mesh_file.h"
#include "batten/io/scene/deform_scene.h"
#include "batten/mesh/prepared_mesh.h"

namespace batten {

/// Finds selections, cuts and proposed features of one scene when they are asked for, on the mesh
/// as it was read, and keeps them. Its functions throw InputError with the place of the word: an
/// unknown name (the nearest is offered), a name that selects nothing, selections that need each
/// other.
class VertexSelector {
 public:
  VertexSelector(const SceneSelections& scene, const MeshFile& file, const TriangleMesh& mesh);

  /// The vertices of a selection, cut or proposal by its name, ascending: nodes of the file.
  std::vector<int> of(const LocatedString& name);
  /// The vertices of several names together, ascending; '*' stands for any letters.
  std::vector<int> of(const std::vector<LocatedString>& names);
  /// The names that a word with '*' means, without those of selections that are being found now.
  std::vector<LocatedString> matching(const LocatedString& word);
  /// The proposal of that name, or nullptr.
  const DetectedFeature* proposal(const std::string& name);
  const std::vector<DetectedFeature>& proposals();
  int vertex_of_label(long label, const SourceLocation& location) const;
  /// The vertices of a line in their order: the shortest way along edges through the vertices that
  /// the rule gives, with creases counted as shorter than they are.
  std::vector<int> path(const LineSpec& rule);

 private:
  // Vertices that meet all conditions of a rule; the next three find those of one condition.
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
  VecX saliency_;  // once asked for
};

}  // namespace batten
