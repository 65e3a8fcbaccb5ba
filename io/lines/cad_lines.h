// Reads curves and surfaces from IGES, STEP and BREP files, and writes curves to them.
#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "batten/io/lines/named_lines.h"
#include "batten/skinning/lines/character_line.h"

namespace batten {

/// Reads every curve of an IGES (.igs, .iges), STEP (.stp, .step) or BREP (.brep, .brp; in mm)
/// file. These are the edges of its shapes (an edge shared by faces once) and the free curves. With
/// `creases`, only the edges of faces are read, plus the creases inside faces, which split the
/// edges at which they end. Coordinates are converted from the file's unit to the model unit.
/// Curves in the parameter plane of a face and edges of length zero are skipped.
///
/// A curve is named after the label of the curve in the file. If several have the same label, it is
/// numbered from the second one on. Without a label, the name is "edge1", "edge2" … in file order.
/// The curve keeps the parametrisation and direction of the file; its derivatives are exact.
/// Straight lines and non-rational splines of degree 3 or less are piecewise_cubic(), and their
/// breaks() are all knots. For other B-splines, breaks() are the knots whose multiplicity allows a
/// C1 discontinuity.
///
/// Throws InputError: a missing or empty file, an unknown extension, a file that is truncated or
/// has another format (with the line, if known), an entity that OpenCASCADE cannot convert, a file
/// without curves, a unit that is not positive.
std::vector<CharacterLine> read_cad_lines(const std::filesystem::path& file,
                                          double model_unit_in_metres, bool creases = false);

/// A trimmed face of a CAD file, for distance queries. Copies share the data.
class CadSurface {
 public:
  /// Distance from `p` to the closest point of the face, in model units. Newton's method starts at
  /// the closest samples of the face and of its edges. It may find only a local minimum if the face
  /// approaches itself between samples. Takes about 0.1 ms. Not thread-safe.
  double distance(const Vec3& p) const;
  /// A lower bound of distance(): the distance to the bounding box of the face. Takes nanoseconds.
  double distance_lower_bound(const Vec3& p) const;

 private:
  friend std::vector<CadSurface> read_cad_surfaces(const std::filesystem::path&, double);
  struct Data;
  std::shared_ptr<const Data> data_;
};

/// Distance from `p` to the closest of several faces. `first`: index of the face to try first;
/// updated to the closest face. Faces whose bounding boxes are farther away are skipped. So the
/// next query nearby costs little more than one face, whatever their number. Throws InputError if
/// `faces` is empty.
double distance(const std::vector<CadSurface>& faces, const Vec3& p, size_t& first);

/// Reads the faces of a file in file order; there may be none. Throws InputError as
/// read_cad_lines() does for files and entities.
std::vector<CadSurface> read_cad_surfaces(const std::filesystem::path& file,
                                          double model_unit_in_metres);

// Writes curves to STEP and IGES files.

/// Writes curves to a CAD file whose format is selected by the extension; the back end of
/// write_curves(). All entries must have curves. Throws InputError for a unit that CAD files cannot
/// declare and for a file that cannot be written, Error if OpenCASCADE fails.
void write_cad_curves(const std::filesystem::path& path, const std::vector<NamedCurve>& curves,
                      const CurveFileOptions& options);

}  // namespace batten
