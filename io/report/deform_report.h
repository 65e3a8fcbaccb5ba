// report.json of a deformed mesh, measured on the finished mesh rather than copied from the solver.
#pragma once

#include <string>
#include <vector>

#include "batten/fairing/curves/curve_fit.h"
#include "batten/fairing/curves/fairness.h"
#include "batten/io/report/run_report.h"
#include "batten/mesh/element_quality.h"
#include "batten/mesh/features/feature_detection.h"

namespace batten {

/// Results of `batten deform`. Lengths are in model units. Suffixes: *_error is relative to the
/// feature's size, *_residual to the mesh's size; *_deg is in degrees, *_s in seconds.
struct DeformReport : RunReport {
  std::string mesh_file, format;
  int nodes = 0, faces = 0;
  double size = 0, largest_coordinate = 0;

  /// Statistics of one edit.
  struct Edit {
    std::string name;
    int moving = 0, unknowns = 0, soft_equations = 0, hard_constraints = 0, feature_constraints = 0;
    int redundant_count = 0, point_equations = 0;
    double largest_displacement = 0, hard_residual = 0;
    /// Largest coordinate change in the last correction step, relative to the mesh's size.
    double last_correction = 0;
    int iterations = 0;  ///< iterations of the rotation estimate; 0: not used
    bool found = true;   ///< true: the rotation estimate converged
    double setup_s = 0, edit_s = 0;
  };
  std::vector<Edit> edits;

  /// Deviation of a form feature from a similarity transform of its original shape.
  struct Feature {
    std::string name;
    int vertices = 0;
    double size = 0;  ///< diagonal of its bounding box
    /// Largest vertex distance from the original feature, moved by the best-fit similarity.
    double max_rigid_error = 0;
    double scale = 1, rotation_deg = 0, moved = 0;  ///< parameters of that similarity; model units
  };
  std::vector<Feature> features;

  /// A chain of vertices driven by a curve.
  struct Curve {
    std::string name;
    int vertices = 0, segments = 0;
    Deviation fairing;  ///< deviation of the vertices from the faired curve
    double wavelength = 0;
    double largest_shift = 0;  ///< largest displacement caused by the curve's loads
    double max_residual = 0;   ///< largest final distance of the vertices from the curve
    Fairness before, after;
  };
  std::vector<Curve> curves;

  /// A boundary loop, numbered as in `loop` of [[select]].
  struct Hole {
    int loop = 0, vertices = 0;
    std::string feature;  ///< name of the feature that contains it; empty: none
    HoleMeasure before, after;
  };
  std::vector<Hole> holes;

  /// Non-shell elements, and how they followed the shells.
  struct Attached {
    std::vector<std::pair<std::string, int>> elements;  ///< count per element kind in the deck
    /// Rigid elements, bushes and bolts that move as rigid bodies.
    int connections = 0;
    /// Largest distance of their nodes from a rigid-body motion.
    double max_rigid_error = 0;
    std::string worst_connection;       ///< the connection with that error
    int moved_with_shells = 0;          ///< non-shell nodes that moved with the shells
    std::vector<long> inverted_solids;  ///< element numbers in the deck
  };
  Attached attached;

  QualitySummary before, after;
  std::vector<long> inverted;  ///< numbers of inverted faces in the file
  /// Largest displacement of a node, and the node's number in the file; -1: none moved.
  double largest_displacement = 0;
  long largest_displacement_node = -1;
  double rounding = 0;  ///< largest |written − computed| of a coordinate (MeshRounding)
};

/// Acceptance checks that the reported numbers violate:
/// - residuals and max_rigid_error ≤ 1e-12, or ≤ 16 rounding errors of the largest coordinate if
///   that is more;
/// - no inverted faces and no inverted solids;
/// - last correction ≤ 1e-9;
/// - connections rigid to within 1e-12 of the size;
/// - finite numbers only.
std::vector<FailedCheck> failed_checks(const DeformReport& report);

/// The report as JSON text. Numbers that are not finite become the strings "nan" and "inf".
std::string to_json(const DeformReport& report);

}  // namespace batten
