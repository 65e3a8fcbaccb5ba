// Reads mesh files and writes them back with new node coordinates; everything else is unchanged.
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

/// A mesh together with the file that it was read from. MeshFile has value semantics; copies share
/// their data. Supported formats:
///
///   .obj               polygons; sets from `g` and `o`; properties from `usemtl`, with the
///                      colours of the .mtl file if it exists; cage_tags() from `t`
///   .off               OFF, COFF, NOFF, STOFF and combinations; text only
///   .ply               text, or binary of either byte order
///   .stl               text or binary; corners with equal coordinates become one node; sets
///                      from `solid`
///   .vtp .vtu          VTK XML
///   .bdf .nas .dat     Nastran bulk data: GRID, CTRIA3, CTRIAR, CQUAD4, CQUADR, CTRIA6, CQUAD8;
///                      small, large and free fields; CORD1R, CORD1C, CORD1S, CORD2R, CORD2C,
///                      CORD2S; INCLUDE; properties by PID, node sets from SET1
///   .inp               Abaqus and CalculiX: at most one part and one instance of it; shells,
///                      membranes, plane elements of 3, 4, 6 and 8 nodes; *SYSTEM, *NODE with
///                      SYSTEM=, *PARAMETER, *INCLUDE, INPUT=; sets from *NSET, *ELSET; properties
///                      from *… SECTION
///   .k .key .dyn       LS-DYNA keyword: *NODE, *ELEMENT_SHELL, *PART, *SET_NODE, *SET_SHELL,
///                      *INCLUDE, *INCLUDE_PATH; standard, I10 and long format, commas
///   .rad               Radioss starter, version 51 and later: /NODE, /SHELL, /SH3N, /PART,
///                      /GRNOD/NODE, #include
///
/// Non-shell entities of decks are parsed for their nodes and listed by other_elements().
/// Everything else is copied verbatim; warnings() counts the elements among it.
///
/// Coordinates are global. A node in a local coordinate system is transformed when it is read, and
/// transformed back when it is written. A coordinate system defined by nodes follows these nodes.
class MeshFile {
 public:
  /// Reads a file; its extension determines the format.
  ///
  /// Throws InputError, "file:line:column: found …, expected …", if the file cannot be read or
  /// would be misread. Examples: an undefined coordinate system, generated nodes, superelements,
  /// several parts or instances, a duplicate number, a truncated deck. The location of an error in
  /// an included file refers to that file. If an included file cannot be read, or includes itself,
  /// the message lists the locations of all including lines.
  ///
  /// Cost: O(size); text is read at 60 to 120 MB/s and needs three to six times its size in memory.
  static MeshFile read(const std::filesystem::path& path);
  /// True if read() supports the extension.
  static bool can_read(const std::filesystem::path& path);

  /// Creates a mesh that belongs to no file: nodes and faces are numbered from 1, there are no
  /// sets. write() throws InputError for such a mesh.
  static MeshFile from_shells(ShellMesh shells);

  /// The faces and the nodes of the mesh.
  const ShellMesh& shells() const;
  /// The number of a node in the file: its id in a deck, its position otherwise (from 1 in OBJ;
  /// from 0 in OFF, PLY, STL and VTK). Cost: O(1).
  long node_label(int node) const;
  /// The number of a face in the file: the element id in a deck; in other formats counted like
  /// nodes (VTK: cell index among all cells). Cost: O(1).
  long face_label(int face) const;
  /// The node or face with this number in the file; empty if there is none. Cost: O(1), or O(log n)
  /// for decks with sparse numbers.
  std::optional<int> node_of_label(long label) const;
  std::optional<int> face_of_label(long label) const;

  using Set = MeshSet;
  /// The sets in file order. Sets without any node or face of the mesh are omitted.
  const std::vector<Set>& sets() const;
  /// The properties, each with the set of its faces. In a deck, a property stands for thickness and
  /// material.
  const std::vector<Set>& properties() const;
  /// The non-shell elements and connections of a deck, in file order; empty for other formats.
  const std::vector<NonShellElement>& other_elements() const;
  /// Semi-sharp creases and corners of the mesh as a Catmull-Clark control cage. They come from the
  /// OBJ tags `t crease 2/1/0 a b s` and `t corner n/n/0 …`, whose node indices are 0-based. Empty
  /// for other formats.
  ///
  /// `t interpolateboundary` is accepted if its value agrees with the boundary rule of
  /// catmull_clark(). `t facevarying…` is ignored. Throws InputError, "file:line:column: …", for
  /// the first unsupported tag: a hole, another crease method, a crease that is no mesh edge, an
  /// invalid number.
  const CageTags& cage_tags() const;
  /// Complete sentences about file content that is not part of the mesh.
  const std::vector<std::string>& warnings() const;
  /// Name of the format for messages: "Nastran bulk data", …
  const std::string& format() const;

  /// Included files of the deck, relative to its folder. write() stores them beside the new deck
  /// under the same names, whether changed or not. Files outside the deck's folder are not listed:
  /// they are not written, and their nodes cannot be moved.
  std::vector<std::filesystem::path> included_files() const;

  using Rounding = MeshRounding;
  /// Writes the file as it was read, but with the given coordinates (n×3), together with
  /// included_files(). Each file is written atomically. A deck of several files never overwrites a
  /// file that was read.
  ///
  /// In text, binary PLY and binary STL, only the coordinates of moved nodes are replaced; all
  /// other bytes stay. A coordinate equal to the one that was read keeps its digits. In decks it
  /// also keeps them in two further cases: if no number in its field is nearer, or if it moved by
  /// less than 1e-13 of the largest coordinate (rounding noise of an edit that moves nothing).
  ///
  /// A replaced coordinate gets the fewest digits that reproduce the double. If the field is too
  /// narrow, it gets the nearest number that fits. Field widths: Nastran 8 or 16 columns, and 16
  /// characters between commas (solvers keep 8 of them unless the GRID has a star); LS-DYNA 16 or
  /// 20; Abaqus and Radioss 20; binary files may have single precision.
  ///
  /// STL normals are recomputed. Other normals in the file, which would become wrong, are reported
  /// by warnings(). VTP and VTU files are rewritten completely: all arrays are kept except normals,
  /// and coordinates become doubles if single precision would round them.
  ///
  /// Throws InputError for the extension of another format, a wrong number of points, or
  /// coordinates that are not finite or do not fit into their fields. Also throws it if a moved
  /// node lies in a file outside the deck's folder or has a coordinate given by a parameter, and
  /// for the errors of AtomicFile.
  Rounding write(const std::filesystem::path& path, const Points& points,
                 const MeshWriteOptions& options = {}) const;

 private:
  explicit MeshFile(std::shared_ptr<const MeshContent> content);
  std::shared_ptr<const MeshContent> content_;
};

/// Writes a mesh that was not read from a file. Formats: .obj and .off (text, exact), .ply, .stl
/// (binary; STL in single precision), .vtp and .vtu (doubles), .glb and .3mf (single precision).
///
/// Second-order faces become quadratic cells in VTU, and polygons through all their nodes in OBJ,
/// PLY, OFF and VTP. STL, GLB and 3MF get triangles. Each face may be in at most one face set. The
/// formats store face sets as follows:
///
///   .obj         groups (`g`); coloured sets also get materials (`usemtl`) in a .mtl file
///   .ply         face colours (red, green, blue), if any set has a colour
///   .vtp .vtu    the cell data Set (-1: in none) and the field data Set_names
///   .glb         one mesh and one node per set, with its name and colour; normals break at edges
///                of 30 degrees or more; coordinates are in metres, y up, as glTF requires
///   .3mf         triangle materials (name and colour) of a single object, so that closed surfaces
///                stay closed; coordinates are in millimetres, with six decimals
///   .stl .off    not stored: these formats have no sets
///
/// `unit_in_metres`: length of the coordinate unit in metres; required by .glb and .3mf, ignored by
/// the other formats, which state no unit. The result lists the files written beside `path`. All
/// files are written atomically.
///
/// Throws InputError for an unsupported extension, an index out of range, a face with fewer than 3
/// nodes, or a colour that is not "#rrggbb". Also throws it for a coordinate that is not finite or
/// (GLB, 3MF) exceeds single precision, for a missing unit, and for the errors of AtomicFile.
std::vector<std::filesystem::path> write_mesh(const std::filesystem::path& path,
                                              const ShellMesh& mesh,
                                              const std::vector<MeshSet>& sets = {},
                                              double unit_in_metres = 0);
/// File extensions, with the dot, that write_mesh() supports.
const std::vector<std::string>& mesh_file_endings();

}  // namespace batten
