// The loops of lines around the faces of CAD files.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace batten {

/// The lines around a face, by the names that read_cad_lines() gives them with creases.
struct CadFaceBoundary {
  std::string name;                             ///< "face 1" … by its place in the file
  std::vector<std::vector<std::string>> loops;  ///< the outer one first
  std::vector<std::string> inner;               ///< lines on which a face meets itself: seams
  bool convex = false;  ///< one loop, all of whose corners turn the face's own way
  bool annulus() const { return !inner.empty() && loops.size() == 2; }  ///< a tube's two rims
};

/// A line between two faces.
struct CadSharedEdge {
  std::string line;
  double angle_deg = 0;  ///< largest angle between the faces along it, as EdgeContinuity's
};

/// All faces of a file, in its order, those with creases inside as their smooth parts.
struct CadFaceTopology {
  std::vector<CadFaceBoundary> faces;
  std::vector<CadSharedEdge> joins;
  double size = 0;  ///< diagonal of the box around their lines, model units
  double gap = 0;   ///< between ends of lines that meet in one vertex, the largest
};

/// The loops of all faces of a file. A closed face (a sphere, a torus) has none. Where faces
/// that meet have edges of their own, as trimmed surfaces of IGES files do, the loops have different lines in
/// one place. Throws InputError as read_cad_lines() does of files and entities.
CadFaceTopology read_cad_loops(const std::filesystem::path& file, double model_unit_in_metres);

}  // namespace batten
