// Names of a deform scene as vertices of its mesh.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "batten/io/meshes/mesh_file.h"
#include "batten/io/scene/deform_scene.h"
#include "batten/mesh/prepare.h"

namespace batten {

/// Selections, cuts and proposed features of one scene, found when they are asked for. All are
/// made on the mesh as it was read. Throws InputError with the place of the word: an unknown name
/// (the nearest is offered), one that selects nothing, selections that need each other.
class VertexSelector {
 public:
  VertexSelector(const DeformScene& scene, const MeshFile& file, const TriangleMesh& mesh);

  /// Vertices of one name, ascending: selection, cut or proposal.
  std::vector<int> of(const PlacedWord& name);
  /// Of several together; '*' stands for any letters.
  std::vector<int> of(const std::vector<PlacedWord>& names);
  /// The names that a word with '*' means; a selection's own name is not among those it asks for.
  std::vector<PlacedWord> matching(const PlacedWord& word);
  /// The proposal of that name, or nullptr.
  const FeatureProposal* proposal(const std::string& name);
  const std::vector<FeatureProposal>& proposals();
  int vertex_of_label(long label, const FilePlace& place) const;
  /// Vertices in order: the shortest way along edges past all of them, where creases count as
  /// shorter than they are. Throws InputError.
  std::vector<int> path(const LineRule& rule);

 private:
  // What meets all conditions of a rule; then the parts of some of them.
  std::vector<int> select(const SelectRule& rule);
  std::vector<int> loop_of(const SelectRule& rule) const;
  std::vector<int> within_distance(const SelectRule& rule);
  std::vector<int> listed_vertices(const SelectRule& rule) const;
  std::vector<int> cut(const CutRule& rule);
  std::vector<std::string> names();

  const DeformScene& scene_;
  const MeshFile& file_;
  const TriangleMesh& mesh_;
  std::map<std::string, std::vector<int>> found_;
  std::vector<std::string> under_way_;
  std::vector<FeatureProposal> proposals_;
  bool proposed_ = false;
};

}  // namespace batten
