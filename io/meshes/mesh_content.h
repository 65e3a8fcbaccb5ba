// SPDX-License-Identifier: MPL-2.0
// In-memory content of a mesh file, and the readers and writers of all mesh formats. Not installed.
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

/// Node or face numbers (labels) of a file: maps indices to labels and back.
class Labels {
 public:
  /// Consecutive labels: first, first + 1, …, first + count − 1.
  static Labels counted_from(long first, int count);
  /// Arbitrary labels, expected to be unique. If duplicate() returns a value, find() is undefined.
  explicit Labels(std::vector<long> labels = {});
  /// The two indices of the first label that occurs twice, in ascending order; empty if all labels
  /// are unique.
  std::optional<std::pair<int, int>> duplicate() const { return duplicate_; }

  /// Number of labels.
  int count() const { return count_; }
  /// The label of an index.
  long of(int index) const { return labels_.empty() ? first_ + index : labels_[index]; }
  /// The index of a label; empty if there is no such label. Cost: O(1), or O(log n) for sparse
  /// labels.
  std::optional<int> find(long label) const;

 private:
  long first_ = 0;
  int count_ = 0;
  std::vector<long> labels_;                    // empty: labels are consecutive, from first_
  std::vector<int> dense_;                      // index of label − first_; -1: none
  std::vector<std::pair<long, int>> by_label_;  // replaces dense_ if labels are sparse
  std::optional<std::pair<int, int>> duplicate_;
};

/// A mesh and everything else that its file contains. Each format derives a class that stores what
/// it needs to write the file back.
struct MeshContent {
  virtual ~MeshContent() = default;
  /// Writes the file with new coordinates, as specified by MeshFile::write(). The caller has
  /// checked that `points` has one finite row per node and that the extension is in `extensions`.
  virtual MeshRounding write(const std::filesystem::path& path, const Points& points,
                             const MeshWriteOptions& options) const = 0;
  /// Included files that write() stores beside the main file; see MeshFile::included_files().
  virtual std::vector<std::filesystem::path> included_files() const { return {}; }
  /// See MeshFile::folder_in_tree().
  virtual std::filesystem::path folder_in_tree() const { return {}; }

  /// Name of the format, for messages.
  std::string format;
  /// Lower-case extensions of the format, with the dot.
  std::vector<std::string> extensions;
  ShellMesh shells;
  Labels node_labels, face_labels;
  std::vector<MeshSet> sets, properties;
  std::vector<NonShellElement> other_elements;
  std::vector<SurfaceTie> ties;
  std::vector<std::string> warnings;
  std::string element_counts;  ///< the warning that counts what is not a shell; may be empty
  CageTags cage_tags;
  /// Reason why `cage_tags` does not represent all cage tags of the file, as "file:line:column: …";
  /// empty if it does.
  std::string cage_problem;
};

/// Signature of the readers: reads a file and returns its content. Throws InputError.
using MeshContentReader = std::unique_ptr<MeshContent>(const std::filesystem::path&);
MeshContentReader read_obj_mesh, read_off_mesh, read_ply_mesh, read_stl_mesh, read_vtk_mesh,
    read_gmsh_mesh, read_nastran_deck, read_abaqus_deck, read_lsdyna_deck, read_radioss_deck;

/// Validated input of a mesh writer; see write_mesh().
struct MeshOutput {
  const std::filesystem::path& path;
  const ShellMesh& mesh;
  const std::vector<MeshSet>& sets;
  double unit_in_metres = 0;
};
/// Writers of the individual formats; see write_mesh().
void write_off_mesh(const MeshOutput& output);
void write_ply_mesh(const MeshOutput& output);
void write_stl_mesh(const MeshOutput& output);
void write_vtk_mesh(const MeshOutput& output);
void write_glb_mesh(const MeshOutput& output);
void write_3mf_mesh(const MeshOutput& output);
void write_abaqus_mesh(const MeshOutput& output);
void write_nastran_mesh(const MeshOutput& output);
/// Writes an OBJ file. The result is the material file (.mtl), if one was written.
std::vector<std::filesystem::path> write_obj_mesh(const MeshOutput& output);
/// The index of the set of each face; -1 if it is in none. If a face is in several sets, the last
/// one wins. Throws InputError if a set contains a face index out of range.
std::vector<int> set_of_faces(const ShellMesh& mesh, const std::vector<MeshSet>& sets);

/// The nodes of a face in order around its outline, including mid-side nodes.
std::vector<int> outline_of(const ShellMesh& mesh, int face);
/// Triangulates a face for formats that store triangles only. Quads are split along the shorter
/// diagonal, larger polygons into a fan. Second-order faces get one triangle per corner, cut off at
/// the mid-side nodes.
std::vector<std::array<int, 3>> triangles_of(const ShellMesh& mesh, int face);
/// The number of nodes that no face uses.
int unused_nodes(const ShellMesh& mesh);

// Colours of mesh files.

/// Parses "#rrggbb" into red, green and blue (0 to 255); empty for "". Throws InputError for any
/// other text.
std::optional<std::array<int, 3>> mesh_colour(const std::string& hex);
/// Formats red, green and blue (0 to 255) as "#rrggbb".
std::string hex_of(const std::array<int, 3>& colour);

}  // namespace batten
