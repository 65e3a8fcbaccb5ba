// Readers of lines and surfaces in IGES, STEP and BREP files.
#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "batten/skinning/lines/character_line.h"
#include "batten/io/lines/named_lines.h"

namespace batten {

/// Reads every curve of an IGES (.igs, .iges), STEP (.stp, .step) or BREP (.brep, .brp; in mm)
/// file: the edges of its shapes (an edge that faces share once) and the curves that stand alone;
/// with `creases` the edges of its faces only, and the creases inside of these, which cut the edges
/// where they end. Coordinates are converted from the unit that the file declares into the model's.
/// Curves in the parameter plane of a face and edges without length are left out.
///
/// A line has the label that the file gives the curve as its name (numbered from the second on when
/// several have the same), otherwise "edge1", "edge2" … by its place in the file. It keeps the
/// file's own parameter and direction; its derivatives are exact. Straight lines and non-rational
/// splines of degree 3 or less are piecewise_cubic(), and breaks() are all their knots; of other
/// B-splines they are the knots that are not C1 by their multiplicity.
///
/// Throws InputError: no such file, an extension other than these, an empty file, a file of another
/// format or cut short (with the line where that shows), an entity that OpenCASCADE cannot convert,
/// a file without curves, a unit that is not positive.
std::vector<CharacterLine> read_cad_lines(const std::filesystem::path& file,
                                          double model_unit_in_metres, bool creases = false);

/// A trimmed face of a CAD file, from which distances are measured. Copies share the data.
class CadSurface {
 public:
  /// Distance from `p` to the nearest point of the face, in model units. Newton's method starts
  /// from the nearest samples of the face and of its edges, so it may find a local minimum where
  /// the face comes near itself between samples. About 0.1 ms. Not to be called from two threads at
  /// once.
  double distance(const Vec3& p) const;
  /// A lower bound of distance(): that from a box around the face. Nanoseconds.
  double distance_lower_bound(const Vec3& p) const;

 private:
  friend std::vector<CadSurface> read_cad_surfaces(const std::filesystem::path&, double);
  struct Data;
  std::shared_ptr<const Data> data_;
};

/// Distance from `p` to the nearest of some faces. `first`: the one that is asked first, then the
/// nearest: those whose boxes are farther away are not asked, so that the next point near by costs
/// little more than one face, however many there are. Throws InputError when there is none.
double distance(const std::vector<CadSurface>& faces, const Vec3& p, size_t& first);

/// Reads the faces of a file in its order; there may be none. Throws InputError as read_cad_lines()
/// does of files and entities.
std::vector<CadSurface> read_cad_surfaces(const std::filesystem::path& file,
                                          double model_unit_in_metres);


// Writes curves to STEP and IGES files. Internal.

/// Writes CAD files, by their ending, for write_curves(). All lines have curves. Throws InputError:
/// a unit that CAD files cannot have, a file that cannot be written; Error when OpenCASCADE fails.
void write_cad_curves(const std::filesystem::path& path, const std::vector<NamedCurve>& curves,
                      const CurveFileOptions& options);

}  // namespace batten
