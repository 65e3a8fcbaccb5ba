// What the readers of mesh files hand over. Not installed.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "batten/io/meshes/mesh_file_types.h"
#include "batten/mesh/shell_mesh.h"

namespace batten {

/// Numbers of nodes or faces, both ways.
class Labels {
 public:
  /// first, first + 1, …
  static Labels counted_from(long first, int count);
  /// Any numbers, each once: ask twice() before anything else.
  explicit Labels(std::vector<long> labels = {});
  /// Positions of the first number that is there twice, the earlier one first.
  std::optional<std::pair<int, int>> twice() const { return twice_; }

  int count() const { return count_; }
  long of(int index) const { return labels_.empty() ? first_ + index : labels_[index]; }
  std::optional<int> find(long label) const;

 private:
  long first_ = 0;
  int count_ = 0;
  std::vector<long> labels_;                    // empty: counted
  std::vector<int> dense_;                      // by label - first_, -1 where there is none
  std::vector<std::pair<long, int>> by_label_;  // or this
  std::optional<std::pair<int, int>> twice_;
};

struct MeshContent {
  virtual ~MeshContent() = default;
  /// `points` have the right number and are finite, the extension is one of `extensions`.
  virtual MeshRounding write(const std::filesystem::path& path, const Points& points,
                             const MeshWriteOptions& options) const = 0;

  std::string format;
  std::vector<std::string> extensions;
  ShellMesh shells;
  Labels node_labels, face_labels;
  std::vector<MeshSet> sets, properties;
  std::vector<std::string> warnings;
};

using MeshContentReader = std::unique_ptr<MeshContent>(const std::filesystem::path&);
MeshContentReader read_obj_mesh, read_off_mesh, read_ply_mesh, read_stl_mesh, read_vtk_mesh,
    read_nastran_deck, read_abaqus_deck, read_lsdyna_deck;

/// Each into its own format; the mesh has been checked.
void write_obj_mesh(const std::filesystem::path& path, const ShellMesh& mesh);
void write_off_mesh(const std::filesystem::path& path, const ShellMesh& mesh);
void write_ply_mesh(const std::filesystem::path& path, const ShellMesh& mesh);
void write_stl_mesh(const std::filesystem::path& path, const ShellMesh& mesh);
void write_vtk_mesh(const std::filesystem::path& path, const ShellMesh& mesh);

/// The nodes of a face in the order in which its outline runs through them.
std::vector<int> outline_of(const ShellMesh& mesh, int face);
/// Nodes that no face has.
int unused_nodes(const ShellMesh& mesh);
/// In lower case, with the dot.
std::string lower_extension(const std::filesystem::path& path);
/// "1 node", "2 nodes".
std::string counted(long count, const std::string& noun);

}  // namespace batten
