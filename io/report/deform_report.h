// report.json of a deformed mesh: measured on the finished mesh, not copied from the solver.
#pragma once

#include <string>
#include <vector>

#include "batten/fairing/curves/curve_fit.h"
#include "batten/fairing/curves/fairness.h"
#include "batten/io/report/run_report.h"
#include "batten/mesh/element_quality.h"
#include "batten/mesh/features/feature_detection.h"

namespace batten {

/// What `batten deform` did. Lengths are in model units, *_error over the feature's size,
/// *_residual over the mesh's size, *_deg in degrees, *_s in seconds.
struct DeformReport : RunReport {
  std::string mesh_file, format;
  int nodes = 0, faces = 0;
  double size = 0, largest_coordinate = 0;

  struct Edit {
    std::string name;
    int moving = 0, unknowns = 0, soft_equations = 0, hard_constraints = 0, feature_constraints = 0;
    int redundant_count = 0, point_equations = 0;
    double largest_displacement = 0, hard_residual = 0;
    double last_correction = 0;  ///< largest change of a coordinate in the last correction step,
                                 ///< over the mesh's size
    int iterations = 0;          ///< of the estimate of the shape; 0 without one
    bool found = true;           ///< whether the estimate settled
    double setup_s = 0, edit_s = 0;
  };
  std::vector<Edit> edits;

  struct Feature {
    std::string name;
    int vertices = 0;
    double size = 0;             ///< diagonal of its box
    double max_rigid_error = 0;  ///< largest distance of its vertices from their places on the mesh
                                 ///< as it was read, moved by the best similarity
    double scale = 1, rotation_deg = 0, moved = 0;  ///< that similarity
  };
  std::vector<Feature> features;

  /// A line of vertices that a curve drives.
  struct Curve {
    std::string name;
    int vertices = 0, segments = 0;
    Deviation fairing;  ///< deviation of the vertices from the faired curve
    double wavelength = 0;
    double largest_shift = 0;  ///< largest displacement by the curve's loads
    double max_residual = 0;   ///< largest distance of the vertices from the curve in the end
    Fairness before, after;
  };
  std::vector<Curve> curves;

  /// A boundary loop, numbered as [[select]] loop is.
  struct Hole {
    int loop = 0, vertices = 0;
    std::string feature;  ///< name of the feature that holds it, or ""
    HoleMeasure before, after;
  };
  std::vector<Hole> holes;

  /// Elements that are no shells, and what became of them.
  struct Attached {
    std::vector<std::pair<std::string, int>> elements;  ///< how many of each kind the deck has
    int connections = 0;                ///< rigid elements, bushes and bolts that keep their shape
    double max_rigid_error = 0;         ///< largest distance of their nodes from a rigid motion
    std::string worst_connection;       ///< the connection where that is
    int moved_with_shells = 0;          ///< nodes of no shell that moved with the shells
    std::vector<long> inverted_solids;  ///< the deck's numbers
  };
  Attached attached;

  QualitySummary before, after;
  std::vector<long> inverted;  ///< the file's numbers of inverted faces
  double largest_displacement = 0;
  long largest_displacement_node = -1;
  double rounding = 0;  ///< largest |written - computed| of a coordinate (MeshRounding)
};

/// The promises that the report's own numbers break: residuals and max_rigid_error above 1e-12 (or
/// above 16 roundings of the largest coordinate, where that is more), inverted faces, a last
/// correction above 1e-9, connections less rigid than 1e-12 of the size, inverted solids, numbers
/// that are not finite.
std::vector<FailedCheck> failed_checks(const DeformReport& report);

/// The report as JSON text. Numbers that are not finite become the words "nan" and "inf".
std::string to_json(const DeformReport& report);

}  // namespace batten
