// Reads the loops of curves around the faces of CAD files, and the edges that faces share.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace batten {

/// The boundary loops of a face. The curves have the names that read_cad_lines() gives them with
/// `creases`.
struct CadFaceBoundary {
  std::string name;  ///< "face 1", "face 2" … in file order
  /// Names of the curves of each loop; the outer loop first.
  std::vector<std::vector<std::string>> loops;
  std::vector<std::string> inner;  ///< seams: curves along which the face meets itself
  bool convex = false;             ///< one loop without re-entrant corners (tolerance 0.1 rad)
  /// A tube with two boundary circles.
  bool annulus() const { return !inner.empty() && loops.size() == 2; }
};

/// A curve shared by two faces.
struct CadSharedEdge {
  std::string line;
  double angle_deg = 0;  ///< largest angle between the faces along it; see EdgeContinuity
};

/// All faces of a file, in file order. Faces with creases are split into their smooth parts.
struct CadFaceTopology {
  std::vector<CadFaceBoundary> faces;
  std::vector<CadSharedEdge> joins;
  double size = 0;  ///< diagonal of the bounding box of all curves, model units
  double gap = 0;   ///< largest distance between curve ends that meet in one vertex, model units
};

/// Reads the loops of all faces of a file. A closed face (sphere, torus) has none. Adjacent faces
/// of IGES files may have edges of their own. If these cannot be merged, the loops have different,
/// coincident curves. Throws InputError as read_cad_lines() does for files and entities.
CadFaceTopology read_cad_loops(const std::filesystem::path& file, double model_unit_in_metres);

}  // namespace batten
