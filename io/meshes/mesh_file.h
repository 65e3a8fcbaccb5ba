// SPDX-License-Identifier: MPL-2.0
// Reads mesh files, and writes them back with new node coordinates and otherwise unchanged.
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

/// A mesh together with the file from which it was read. MeshFile has value semantics; copies share
/// their data. Supported formats:
///
///   .obj               polygons; sets from `g` and `o`; properties from `usemtl`, with the
///                      colours of the .mtl file if it exists; cage_tags() from `t`
///   .off               OFF, COFF, NOFF, STOFF and combinations; text only
///   .ply               text, or binary with either byte order
///   .stl               text or binary; corners with equal coordinates become one node; sets
///                      from `solid`
///   .vtp .vtu .vtk     VTK XML and legacy: two-dimensional cells; other cells in other_elements()
///   .msh .unv          Gmsh: triangles and quads of first and second order; sets from physical
///                      groups, properties from geometric surfaces. MSH 2.2 and 4.1 as text are
///                      read directly. The program gmsh converts binary files, other versions and
///                      universal files, and converts them back when they are written
///   .bdf .nas .dat .fem  Nastran bulk data (OptiStruct): GRID, CTRIA3, CTRIAR, CQUAD4, CQUADR, CTRIA6, CQUAD8;
///                      small, large and free fields; CORD1R, CORD1C, CORD1S, CORD2R, CORD2C,
///                      CORD2S; INCLUDE; properties from PID, node sets from SET1
///   .inp               Abaqus and CalculiX: at most one part with one instance, nodes of the
///                      assembly; shells, membranes, plane, axisymmetric and thermal elements with
///                      3, 4, 6, 8 and 9 nodes; *SYSTEM, *NODE with SYSTEM=,
///                      *PARAMETER, *INCLUDE, INPUT=; sets from *NSET, *ELSET; properties from
///                      *… SECTION
///   .k .key .dyn       LS-DYNA keyword: *NODE, *ELEMENT_SHELL, *PART, *SET_NODE, *SET_SHELL,
///                      *INCLUDE, *INCLUDE_PATH; standard, I10 and long format, commas
///   .rad               Radioss starter, version 51 and later: /NODE, /SHELL, /SH3N, /PART,
///                      /GRNOD/NODE, include files
///
/// The connectivity of non-shell elements in decks is read, and other_elements() lists them; ties()
/// lists ties and spot welds. Directions rotate with the nodes to which they belong. All other
/// content is copied verbatim; warnings() gives the number of elements in it.
///
/// Coordinates are global. A node in a local coordinate system is transformed when it is read, and
/// transformed back when it is written. A coordinate system defined by nodes follows these nodes.
class MeshFile {
 public:
  /// Reads a mesh file, whose extension determines the format.
  ///
  /// Throws InputError ("file:line:column: found …, expected …") if the file cannot be read or uses
  /// features that are not supported. Examples are undefined coordinate systems, generated nodes,
  /// superelements, several parts or instances, duplicate numbers, and truncated decks. The
  /// location of an error in an included file refers to the included file. If an included file
  /// cannot be read, or includes itself, the message lists the locations of all INCLUDE lines that
  /// lead to it.
  ///
  /// Cost: O(file size). Text is read at 60 to 120 MB/s; reading needs three to six times the size
  /// of the file in memory.
  static MeshFile read(const std::filesystem::path& path);
  /// True if the extension of the file is that of a supported mesh format.
  static bool can_read(const std::filesystem::path& path);
  /// The file extensions that read() supports, with the dot.
  static std::vector<std::string> readable_extensions();

  /// Creates a MeshFile for a mesh that does not belong to a file. Nodes and faces are numbered
  /// from 1, and there are no sets. write() throws InputError for such a mesh.
  static MeshFile from_shells(ShellMesh shells);

  /// The faces and the nodes of the mesh.
  const ShellMesh& shells() const;
  /// The number of a node in the file. In a deck, this is the id of the node; in other formats its
  /// position, counted from 1 in OBJ and from 0 in OFF, PLY, STL and VTK. Cost: O(1).
  long node_label(int node) const;
  /// The number of a face in the file. In a deck, this is the id of the element; in other formats
  /// the position of the face, counted like nodes (in VTK, among all cells). Cost: O(1).
  long face_label(int face) const;
  /// The index of the node or face with the given number in the file; empty if the number does not
  /// exist. Cost: O(1), or O(log n) for decks with sparse numbers.
  std::optional<int> node_of_label(long label) const;
  std::optional<int> face_of_label(long label) const;

  using Set = MeshSet;
  /// The node and face sets in file order, without sets that contain no node or face of the mesh.
  const std::vector<Set>& sets() const;
  /// The properties, each with the faces that have it. In a deck, a property defines thickness and
  /// material.
  const std::vector<Set>& properties() const;
  /// The non-shell elements and connections of a deck, in file order. Empty for other formats.
  const std::vector<NonShellElement>& other_elements() const;
  /// Ties and spot welds of a deck: connections of nodes with surfaces. Empty for other formats.
  const std::vector<SurfaceTie>& ties() const;
  /// Semi-sharp creases and corners, for a mesh that is used as a Catmull-Clark control cage. They
  /// are read from the OBJ tags `t crease 2/1/0 a b s` and `t corner n/n/0 …`, whose node indices
  /// are 0-based. Empty for other formats.
  ///
  /// `t interpolateboundary` is accepted if its value agrees with the boundary rule of
  /// catmull_clark(). `t facevarying…` is ignored. Throws InputError ("file:line:column: …") for
  /// the first unsupported tag: a hole, another crease method, a crease that is not a mesh edge, or
  /// an invalid number.
  const CageTags& cage_tags() const;
  /// Warnings, in complete sentences, about content of the file that is not part of the mesh.
  const std::vector<std::string>& warnings() const;
  /// The one of warnings() that counts the elements of a deck that are not shells, and the nodes
  /// without shells; empty if there are none.
  const std::string& element_counts() const;
  /// Name of the file format for messages, such as "Nastran bulk data".
  const std::string& format() const;

  /// Included files of the deck, relative to its folder. write() writes them under the same names,
  /// relative to the new deck, even if they are unchanged. Files that are included by absolute paths
  /// are not listed: they are not written, so their nodes cannot be moved.
  std::vector<std::filesystem::path> included_files() const;
  /// The folder, relative to an output folder, in which the deck must be written so that all of its
  /// included files lie in the output folder. Empty if no included file lies above the deck; "run"
  /// for a deck run/main.k that includes ../common/mesh.k.
  std::filesystem::path folder_in_tree() const;

  using Rounding = MeshRounding;
  /// Writes the mesh file with the node coordinates `points` (n×3) and otherwise unchanged,
  /// together with included_files(). Returns the largest rounding error of a coordinate. Each file
  /// is written atomically. A deck of several files never overwrites a file that was read: changed
  /// included files need another folder, and unchanged ones that are already there are kept.
  ///
  /// In text files, binary PLY and binary STL, only the coordinates of moved nodes are replaced;
  /// all other bytes are copied. A coordinate that is unchanged keeps its digits. In decks, a
  /// coordinate also keeps its digits in two further cases: if the field cannot store a number that
  /// is nearer to the new value, or if the change is less than 1e-13 of the largest coordinate
  /// (rounding noise).
  ///
  /// A new coordinate is written with the fewest digits that reproduce the double. If the field is
  /// too narrow for these digits, the nearest number that fits is written. Field widths are 8 or 16
  /// columns in Nastran, or 16 characters between commas (of which solvers keep 8 unless the card
  /// is GRID*); 16 or 20 in LS-DYNA; 20 in Abaqus and Radioss. Binary files may have single
  /// precision.
  ///
  /// STL normals are recomputed. warnings() reports normals in other formats, which are not
  /// updated. VTP and VTU files are rewritten completely, with all arrays except normals;
  /// coordinates become doubles if single precision would round them.
  ///
  /// Throws InputError for the extension of another format, a wrong number of points, coordinates
  /// that are not finite or do not fit into their fields, and a moved node that is defined in a
  /// file outside the folder of the deck or by a parameter. Throws FileError if a file cannot be
  /// written.
  Rounding write(const std::filesystem::path& path, const Points& points,
                 const MeshWriteOptions& options = {}) const;

 private:
  explicit MeshFile(std::shared_ptr<const MeshContent> content);
  std::shared_ptr<const MeshContent> content_;
};

/// Writes a mesh to a new file. Formats: .obj and .off (text, exact), .ply (binary), .stl (binary,
/// single precision), .vtp and .vtu (doubles), .glb and .3mf (single precision), .inp (Abaqus and
/// CalculiX: S3, S4, S6, S8R; 20 characters a number), .bdf, .nas and .fem (Nastran: CTRIA3, CQUAD4,
/// CTRIA6, CQUAD8; GRID* with 16 characters a number).
///
/// Second-order faces become quadratic cells in VTU, second-order elements in decks, and polygons
/// through all their nodes in OBJ, PLY, OFF and VTP. In STL, GLB and 3MF all faces are split into
/// triangles. Decks contain no material, section, support or load; polygons with more than four
/// corners are split into triangles there, and faces for which is_degenerate() is true are left out.
/// Each face may belong to at most one face set. The formats store face sets as follows:
///
///   .obj         groups (`g`); coloured sets also get materials (`usemtl`) in a .mtl file
///   .ply         face colours (red, green, blue), if any set has a colour
///   .vtp .vtu    the cell data Set (-1: no set) and the field data Set_names
///   .glb         one mesh and one node per set, with the name and colour of the set; normals are
///                discontinuous at edges of 30 degrees or more; coordinates are in metres, with
///                the y axis up, as glTF requires
///   .3mf         triangle materials (name and colour) of a single object, so that closed surfaces
///                stay closed; coordinates are in millimetres, with six decimals
///   .inp         element sets, with the characters that solvers accept in names
///   .bdf         properties 2, 3, … in the order of the sets, whose names are comments; 1: no set
///   .stl .off    not stored: these formats have no sets
///
/// `unit_in_metres`: length of the coordinate unit in metres; required by .glb and .3mf, ignored by
/// the other formats, which declare no unit. The result lists the files that were written in
/// addition to `path`. All files are written atomically.
///
/// Throws InputError for an unsupported extension, an index out of range, a face with fewer than 3
/// nodes, a colour that is not "#rrggbb", a coordinate that is not finite or (GLB, 3MF) exceeds the
/// range of single precision, and a missing unit. Throws FileError if a file cannot be written.
std::vector<std::filesystem::path> write_mesh(const std::filesystem::path& path,
                                              const ShellMesh& mesh,
                                              const std::vector<MeshSet>& sets = {},
                                              double unit_in_metres = 0);
/// True if a face has fewer than three different corners; no element of a solver has this shape.
bool is_degenerate(const ShellMesh& mesh, int face);
/// The file extensions that write_mesh() supports, with the dot.
const std::vector<std::string>& mesh_file_endings();

}  // namespace batten
