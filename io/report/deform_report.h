// report.json of a deformed mesh: measured on the finished mesh, not copied from the solver.
#pragma once

#include <string>
#include <vector>

#include "batten/fairing/curve_fit.h"
#include "batten/fairing/fairness.h"
#include "batten/io/report/report_parts.h"
#include "batten/mesh/features/holes.h"
#include "batten/mesh/quality.h"

namespace batten {

/// Lengths in model units; *_error over the feature's size, *_residual over the mesh's; degrees.
struct DeformReport : RunReport {
  std::string mesh_file, format;
  int nodes = 0, faces = 0;
  double size = 0, largest_coordinate = 0;

  struct Edit {
    std::string name;
    int moving = 0, unknowns = 0, soft_rows = 0, hard_rows = 0, feature_rows = 0;
    int dropped_rows = 0, guide_rows = 0;
    double largest_displacement = 0, hard_residual = 0;
    double last_correction = 0;  ///< of the last correction step, over the mesh's size
    double set_up_s = 0, edit_s = 0;
  };
  std::vector<Edit> edits;

  struct Feature {
    std::string name;
    int vertices = 0;
    double size = 0;             ///< diagonal of its box
    double max_rigid_error = 0;  ///< after the best similarity from the mesh as it was read
    double scale = 1, turned_deg = 0, moved = 0;
  };
  std::vector<Feature> features;

  /// Lines of vertices that curves drive.
  struct Curve {
    std::string name;
    int vertices = 0, segments = 0;
    Deviation fairing;  ///< of the vertices from the faired curve, model units
    double wavelength = 0;
    double largest_shift = 0;  ///< that the curve's loads add
    double max_residual = 0;   ///< of the vertices from the curve in the end, over the mesh's size
    Fairness before, after;
  };
  std::vector<Curve> curves;

  /// Boundary loops, numbered as [[select]] loop is.
  struct Hole {
    int loop = 0, vertices = 0;
    std::string feature;  ///< that holds it, or ""
    HoleMeasure before, after;
  };
  std::vector<Hole> holes;

  QualitySummary before, after;
  std::vector<long> inverted;  ///< faces, by the file's numbers
  double largest_displacement = 0;
  long largest_displacement_node = -1;
  double rounding = 0;  ///< what the file's fields cost, largest coordinate
};

/// What the report itself shows to be broken: residuals and max_rigid_error above 1e-12 (above
/// what 16 roundings of the largest coordinate cost, where that is more), inverted faces, a last
/// correction above 1e-9, numbers that are not finite.
std::vector<MissedPromise> broken_promises(const DeformReport& report);

/// JSON text; numbers that are not finite become the words "nan" and "inf".
std::string to_json(const DeformReport& report);

}  // namespace batten
