// Lines and surfaces out of IGES and STEP files.
#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "batten/skinning/lines/character_line.h"

namespace batten {

/// Every curve of an IGES (.igs, .iges) or STEP (.stp, .step) file: the edges of its shapes, an
/// edge that faces share once, and the curves that stand alone. Coordinates are turned from the
/// unit that the file declares into the model's. Curves in the parameter plane of a face and edges
/// without length are not among them.
///
/// Lines are named by the label that the file gives the curve (numbered from the second on when
/// several have the same), otherwise "edge1", "edge2" … by their place in the file. Each keeps the
/// file's own parameter and direction; derivatives are exact.
/// breaks(): knots where a B-spline is not C1 by their multiplicity; all knots when the curve is
/// piecewise_cubic(), which straight lines and non-rational splines of degree 3 or less are.
///
/// Throws InputError: no such file, an extension other than these, an empty file, a file of another
/// format or cut short (with the line where that shows), an entity that OpenCASCADE cannot convert,
/// a file without curves, a unit that is not positive.
std::vector<CharacterLine> read_cad_lines(const std::filesystem::path& file,
                                          double model_unit_in_metres);

/// A trimmed face of a CAD file, to compare surfaces with. Copies share the data.
class StoredSurface {
 public:
  /// Distance from `p` (model units) to the nearest point of the face: Newton's method from the
  /// nearest samples of the face and of its edges, so a local minimum is possible where the face
  /// comes back to itself between samples. About 0.1 ms. Not to be called from two threads at once.
  double distance(const Vec3& p) const;

 private:
  friend std::vector<StoredSurface> read_cad_surfaces(const std::filesystem::path&, double);
  struct Data;
  std::shared_ptr<const Data> data_;
};

/// The faces of a file in its order, possibly none. Throws InputError as read_cad_lines does.
std::vector<StoredSurface> read_cad_surfaces(const std::filesystem::path& file,
                                             double model_unit_in_metres);

}  // namespace batten
