// Reads mesh files and writes them back with other coordinates, all else in them unchanged.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "batten/io/meshes/mesh_file_types.h"
#include "batten/mesh/catmull_clark.h"
#include "batten/mesh/shell_mesh.h"

namespace batten {

struct MeshContent;

/// A mesh together with the file that it was read from. It is a value; copies share everything.
/// The formats:
///
///   .obj               polygons; sets from `g` and `o`, properties from `usemtl`, in the
///                      colours of the .mtl file where that is there; cage_tags() from `t`
///   .off               OFF, COFF, NOFF, STOFF and their mixtures; as text
///   .ply               as text or binary of either byte order
///   .stl               as text or binary; corners at the same place are one node; sets from
///                      `solid`
///   .vtp .vtu          VTK XML
///   .bdf .nas .dat     Nastran bulk data: GRID, CTRIA3, CTRIAR, CQUAD4, CQUADR, CTRIA6, CQUAD8;
///                      small, large and free fields; CORD1R, CORD1C, CORD1S, CORD2R, CORD2C,
///                      CORD2S; INCLUDE; properties by PID, node sets from SET1
///   .inp               Abaqus and CalculiX: one part and one instance of it, or none; shells,
///                      membranes, plane elements of 3, 4, 6 and 8 nodes; *SYSTEM, *NODE with
///                      SYSTEM=, *PARAMETER, *INCLUDE, INPUT=; sets from *NSET, *ELSET; properties
///                      from *… SECTION
///   .k .key .dyn       LS-DYNA keyword: *NODE, *ELEMENT_SHELL, *PART, *SET_NODE, *SET_SHELL,
///                      *INCLUDE, *INCLUDE_PATH; standard, I10 and long format, commas
///   .rad               Radioss starter, from version 51 on: /NODE, /SHELL, /SH3N, /PART,
///                      /GRNOD/NODE, #include
///
/// What decks have beside shells comes by its nodes, as other_elements(). All else is kept as it stands,
/// and warnings() counts the elements that are among it. Points are global: a node in a local system
/// is put to its place when it is read, and back into its system when it is written. A system that
/// is defined by nodes follows them.
class MeshFile {
 public:
  /// Reads a file; its extension says the format. Throws InputError, "file:line:column: found …,
  /// expected …", for everything that cannot be read or would be read wrongly: a system that is not
  /// there, generated nodes, superelements, several parts or instances, a number twice, a deck that
  /// ends before its end. In an included file the place is that in it; where one cannot be read, or
  /// includes itself, the places of all including lines are named. O(size): text at
  /// 60 to 120 MB/s, with three to six times its size in memory.
  static MeshFile read(const std::filesystem::path& path);
  /// Whether read() knows the extension.
  static bool can_read(const std::filesystem::path& path);

  /// A mesh that no file holds: nodes and faces counted from 1, no sets. write() refuses it.
  static MeshFile from_shells(ShellMesh shells);

  const ShellMesh& shells() const;
  /// The file's own number of a node: its id in a deck; counted from 1 in OBJ, from 0 in OFF, PLY,
  /// STL, VTK. O(1).
  long node_label(int node) const;
  /// The file's own number of a face: the element's id in a deck; in the other formats counted as
  /// nodes are (VTK: the cell's index among all cells). O(1).
  long face_label(int face) const;
  /// The node, or face, with this number; none when there is no such one. O(1), or O(log n) for
  /// decks with sparse numbers.
  std::optional<int> node_of_label(long label) const;
  std::optional<int> face_of_label(long label) const;

  using Set = MeshSet;
  /// The sets in the file's order. Sets without any node or face of the mesh are left out.
  const std::vector<Set>& sets() const;
  /// The properties (in a deck: thickness and material), each as the set of its faces.
  const std::vector<Set>& properties() const;
  /// What is in a deck beside shells and has nodes, in the file's order; none in other formats.
  const std::vector<NonShellElement>& other_elements() const;
  /// What is sharp of the mesh as a cage: in OBJ `t crease 2/1/0 a b s` and `t corner n/n/0 …`,
  /// whose nodes count from 0; none in other formats. `t interpolateboundary` is known where it
  /// means what catmull_clark() does, `t facevarying…` is of no matter. Throws InputError,
  /// "file:line:column: …", for the first other tag: a hole, another method of creases, a crease
  /// that is no edge, a number that is none.
  const CageTags& cage_tags() const;
  /// Sentences about what is in the file and is not part of the mesh.
  const std::vector<std::string>& warnings() const;
  /// The format's name for messages: "Nastran bulk data", …
  const std::string& format() const;

  /// Included files of the deck, from its folder. write() puts them beside the deck that it writes,
  /// under the same names, changed or not. Not among them: files outside of the deck's folder, which
  /// stay where they are and of which no node can be moved.
  std::vector<std::filesystem::path> included_files() const;

  using Rounding = MeshRounding;
  /// Writes the file as it was read, with other coordinates (n×3), and included_files(). Each appears
  /// whole or not at all; where there are several, none takes the place of one that was read.
  ///
  /// In text and in binary PLY and STL only the coordinates of nodes that moved are replaced: all
  /// other bytes stay, and a coordinate that equals the one that was read keeps its digits. In decks
  /// it does so, too, where it is as near as its field allows, or has moved by less than 1e-13 of the
  /// largest coordinate: an edit that moves nothing leaves the rounding of its sums behind. A
  /// replaced coordinate has the fewest digits that give back the double or, where the field is too
  /// narrow for them, is the nearest number that fits: Nastran 8 or 16 columns and 16 characters
  /// between commas (of which solvers keep 8 unless the GRID has a star), LS-DYNA 16 or 20, Abaqus
  /// and Radioss 20, binary files with single precision. STL normals follow; other normals that would be wrong
  /// are named by warnings(). VTP and VTU are written anew: arrays are kept except normals,
  /// coordinates become doubles where single precision would round.
  ///
  /// Throws InputError: an extension of another format, another number of points, coordinates that
  /// are not finite or do not fit into their fields, a node that moves in a file outside of the
  /// deck's folder or whose coordinate is a parameter, what AtomicFile throws.
  Rounding write(const std::filesystem::path& path, const Points& points,
                 const MeshWriteOptions& options = {}) const;

 private:
  explicit MeshFile(std::shared_ptr<const MeshContent> content);
  std::shared_ptr<const MeshContent> content_;
};

/// Writes a mesh that was not read from a file: .obj, .off (text, exact), .ply, .stl (binary; STL
/// in single precision), .vtp, .vtu (doubles), .glb, .3mf (single precision). Second-order faces
/// become quadratic cells in VTU and polygons through all their nodes in OBJ, PLY, OFF and VTP;
/// STL, GLB and 3MF get triangles. Face sets, of which each face is in one at most, become
///
///   .obj         groups (`g`), and in their colours materials (`usemtl`) of a file .mtl beside it
///   .ply         colours of faces (red, green, blue), where any set has one
///   .vtp .vtu    the cell data Set (-1: in none) and the field data Set_names
///   .glb         a mesh and a node each, by its name, in its colour, with normals that break where
///                faces turn by 30 degrees; coordinates are in metres, y up, as glTF has it
///   .3mf         materials of the triangles, by name and colour, of one object, so that what is
///                closed stays so; coordinates are in millimetres, with six decimals
///   .stl .off    nothing: they have no place for them
///
/// `unit_in_metres`: of the coordinates, which .glb and .3mf need; other files state none. Returns
/// the files that it wrote beside `path`. All appear whole or not at all. Throws InputError:
/// another extension, an index out of range, a face of fewer than 3 nodes, a coordinate that is not
/// finite or (GLB, 3MF) too large for single precision, a colour that is not "#rrggbb", no unit
/// where one is needed, what AtomicFile throws.
std::vector<std::filesystem::path> write_mesh(const std::filesystem::path& path,
                                              const ShellMesh& mesh,
                                              const std::vector<MeshSet>& sets = {},
                                              double unit_in_metres = 0);
/// Endings of files, with their dots, that write_mesh() knows.
const std::vector<std::string>& mesh_file_endings();

}  // namespace batten
