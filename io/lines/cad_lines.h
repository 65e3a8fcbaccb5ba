// SPDX-License-Identifier: MPL-2.0
// Reads curves, faces and the boundary loops of faces from IGES, STEP and BREP files, and writes
// curves to STEP and IGES files.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "batten/io/lines/named_lines.h"
#include "batten/skinning/lines/character_line.h"

namespace batten {

/// Reads every curve of an IGES (.igs, .iges), STEP (.stp, .step) or BREP (.brep, .brp; in mm)
/// file: the edges of its shapes and the free curves. An edge that is shared by faces is read once.
/// If `creases` is true, only the edges of faces are read, after heal_shape() (io/cad/cad_file.h):
/// also creases inside faces and the curves that divide closed faces, but not the seams of tubes.
/// These curves split the edges on which they end. Coordinates are converted from the unit of the file to the
/// model unit. Pcurves (in parameter planes of faces) and edges of length zero are skipped.
///
/// The name of a curve is its label in the file. If several curves have the same label, numbers are
/// appended from the second curve on. Curves without a label are named "edge1", "edge2" … in file
/// order. A curve keeps its parametrisation and direction, and its derivatives are exact. Straight
/// lines and non-rational splines of degree 3 or less are piecewise_cubic(), and their breaks() are
/// all knots. For other B-splines, breaks() are the knots whose multiplicity allows a C1
/// discontinuity.
///
/// `face_count`: gets the number of faces of the file, before heal_shape(); may be null.
///
/// Throws InputError if the file is missing, empty, truncated, of another format (with the line, if
/// it is known) or without curves; if the extension is unknown; if OpenCASCADE cannot convert an
/// entity; or if the unit is not positive.
std::vector<CharacterLine> read_cad_lines(const std::filesystem::path& file,
                                          double model_unit_in_metres, bool creases = false,
                                          int* face_count = nullptr);

/// A trimmed face of a CAD file, for distance queries. Copies share the data of the face.
class CadSurface {
 public:
  /// Distance from `p` to the closest point of the face, in model units. Newton's method starts at
  /// the closest sample points of the face and of its edges. If two parts of the face are closer to
  /// each other than the sample points, the result may be a local minimum. Takes about 0.1 ms. Not
  /// thread-safe.
  double distance(const Vec3& p) const;
  /// A lower bound of distance(), in nanoseconds: the distance from `p` to the face's bounding box.
  double distance_lower_bound(const Vec3& p) const;

 private:
  friend std::vector<CadSurface> read_cad_surfaces(const std::filesystem::path&, double);
  struct Data;
  std::shared_ptr<const Data> data_;
};

/// Distance from `p` to the closest of several CAD faces. `first`: index of the face that is tried
/// first; on return, the index of the closest face. Faces whose bounding boxes are farther away are
/// skipped, so a further query at a nearby point costs little more than a query of a single face.
/// Throws InputError if `faces` is empty.
double distance(const std::vector<CadSurface>& faces, const Vec3& p, size_t& first);

/// Reads the faces of a CAD file for distance queries, in file order; empty if there are no faces.
/// Throws InputError for a file or entity that cannot be read, as read_cad_lines() does.
std::vector<CadSurface> read_cad_surfaces(const std::filesystem::path& file,
                                          double model_unit_in_metres);

// Boundary loops of faces, and edges shared by two faces.

/// The boundary loops of a face of a CAD file. The names of the curves are those of
/// read_cad_lines() with `creases` = true.
struct CadFaceBoundary {
  /// Name of the face: "face 1", "face 2" … in file order; "face 1.1" … for the parts of a face that
  /// heal_shape() divides.
  std::string name;
  /// Names of the curves of each boundary loop, starting with the outer loop.
  std::vector<std::vector<std::string>> loops;
  bool tube = false;    ///< true: a seam joins two boundary loops without corners
  bool convex = false;  ///< true: a single loop without re-entrant corners (tolerance 0.1 rad)
};

/// A curve shared by two faces of a CAD file.
struct CadSharedEdge {
  std::string line;
  double angle_deg = 0;  ///< largest angle between the two faces, degrees
};

/// All faces of a CAD file, with their shared edges. Faces with creases are split at the creases,
/// and closed faces are divided (heal_shape()).
struct CadFaceTopology {
  std::vector<CadFaceBoundary> faces;
  std::vector<CadSharedEdge> joins;
  double size = 0;  ///< diagonal of the bounding box of all curves, model units
  double gap = 0;   ///< largest distance between curve ends at one vertex, model units
};

/// Reads the boundary loops of all faces of a CAD file. Adjacent faces of an IGES file may have separate edges. If these edges cannot be merged, the
/// loops contain different, coincident curves. Throws InputError for a file or entity that cannot
/// be read, as read_cad_lines() does.
CadFaceTopology read_cad_loops(const std::filesystem::path& file, double model_unit_in_metres);

// Writes curves to STEP and IGES files.

/// Writes curves to a STEP or IGES file, depending on the extension; called by write_curves(). All
/// entries of `curves` must have curves, not points only. Throws InputError if CAD files cannot
/// declare the unit or the file cannot be written, and Error if OpenCASCADE fails.
void write_cad_curves(const std::filesystem::path& path, const std::vector<NamedCurve>& curves,
                      const CurveFileOptions& options);

}  // namespace batten
