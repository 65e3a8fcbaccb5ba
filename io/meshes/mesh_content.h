// The content of a mesh file, as its reader returns it. Not installed.
#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "batten/io/files/text.h"
#include "batten/io/meshes/mesh_file_types.h"
#include "batten/mesh/catmull_clark.h"
#include "batten/mesh/shell_mesh.h"

namespace batten {

/// The numbers that a file gives its nodes or faces: from index to number, and back.
class Labels {
 public:
  /// The numbers first, first + 1, …
  static Labels counted_from(long first, int count);
  /// Any numbers, each once. Where duplicate() returns something, find() has no meaning.
  explicit Labels(std::vector<long> labels = {});
  /// The two indices of the first number that is there twice, the smaller one first; none when each
  /// number is there once.
  std::optional<std::pair<int, int>> duplicate() const { return duplicate_; }

  int count() const { return count_; }
  long of(int index) const { return labels_.empty() ? first_ + index : labels_[index]; }
  /// The index of a number; none when it is not there. O(1), or O(log n) for sparse numbers.
  std::optional<int> find(long label) const;

 private:
  long first_ = 0;
  int count_ = 0;
  std::vector<long> labels_;                    // empty: first_, first_ + 1, …
  std::vector<int> dense_;                      // index of label - first_; -1 for none
  std::vector<std::pair<long, int>> by_label_;  // instead of dense_, for sparse numbers
  std::optional<std::pair<int, int>> duplicate_;
};

/// A mesh and what else its file holds. Each format derives from it what it writes back.
struct MeshContent {
  virtual ~MeshContent() = default;
  /// Writes the file with other coordinates, as MeshFile::write() says. The caller has checked that
  /// `points` have the right number and are finite, and that the extension is one of `extensions`.
  virtual MeshRounding write(const std::filesystem::path& path, const Points& points,
                             const MeshWriteOptions& options) const = 0;
  /// Files that write() puts beside the file, as MeshFile::included_files() says.
  virtual std::vector<std::filesystem::path> included_files() const { return {}; }

  std::string format;
  std::vector<std::string> extensions;
  ShellMesh shells;
  Labels node_labels, face_labels;
  std::vector<MeshSet> sets, properties;
  std::vector<NonShellElement> other_elements;
  std::vector<std::string> warnings;
  CageTags cage_tags;
  std::string
      cage_problem;  ///< why these are not all that the file says of its cage; "" for nothing
};

using MeshContentReader = std::unique_ptr<MeshContent>(const std::filesystem::path&);
MeshContentReader read_obj_mesh, read_off_mesh, read_ply_mesh, read_stl_mesh, read_vtk_mesh,
    read_nastran_deck, read_abaqus_deck, read_lsdyna_deck, read_radioss_deck;

/// A mesh that write_mesh() was given, and has checked.
struct MeshOutput {
  const std::filesystem::path& path;
  const ShellMesh& mesh;
  const std::vector<MeshSet>& sets;
  double unit_in_metres = 0;
};
/// Each writes a mesh in one format, as write_mesh() says.
void write_off_mesh(const MeshOutput& output);
void write_ply_mesh(const MeshOutput& output);
void write_stl_mesh(const MeshOutput& output);
void write_vtk_mesh(const MeshOutput& output);
void write_glb_mesh(const MeshOutput& output);
void write_3mf_mesh(const MeshOutput& output);
/// Returns the file of materials where there is one.
std::vector<std::filesystem::path> write_obj_mesh(const MeshOutput& output);
/// The set of each face, -1 for none; the last one where several have it. Throws InputError for a
/// face out of range.
std::vector<int> set_of_faces(const ShellMesh& mesh, const std::vector<MeshSet>& sets);

/// The nodes of a face, middle nodes too, in the order in which they lie around it.
std::vector<int> outline_of(const ShellMesh& mesh, int face);
/// The triangles of a face for formats that have no other faces: a quad along its shorter diagonal,
/// larger polygons as a fan; of second-order faces the corners are cut off at the middle nodes.
std::vector<std::array<int, 3>> triangles_of(const ShellMesh& mesh, int face);
/// The count of nodes that no face has.
int unused_nodes(const ShellMesh& mesh);


// Colours of mesh files. Internal.

/// Red, green and blue, 0 to 255, of "#rrggbb"; none for "". Throws InputError for another text.
std::optional<std::array<int, 3>> mesh_colour(const std::string& hex);
/// "#rrggbb" of such numbers.
std::string hex_of(const std::array<int, 3>& colour);

}  // namespace batten
