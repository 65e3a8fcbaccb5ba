// SPDX-License-Identifier: MPL-2.0
// Contents of report.json for a deformed mesh, measured on the finished mesh.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "batten/fairing/curves/curve_fit.h"
#include "batten/fairing/curves/fair_curve.h"
#include "batten/io/report/run_report.h"
#include "batten/mesh/editing/mesh_editor.h"
#include "batten/mesh/element_quality.h"
#include "batten/mesh/features/feature_detection.h"

namespace batten {

/// Results of `batten deform`. Lengths are in model units. Numbers with the suffix _residual are
/// divided by the size of the mesh, and Feature::max_rigid_error by the size of the feature;
/// Attached::max_rigid_error is in model units. The suffix _deg stands for degrees, _s for seconds.
struct DeformReport : RunReport {
  std::string mesh_file, format;
  int nodes = 0, faces = 0;
  double size = 0, largest_coordinate = 0;

  /// Statistics of one edit.
  struct Edit {
    std::string name;
    MeshEditStatistics statistics;
  };
  std::vector<Edit> edits;

  /// Deviation of a form feature from the similarity transform (rotation, translation, uniform
  /// scaling) that fits it best.
  struct Feature {
    std::string name;
    int vertices = 0;
    double size = 0;  ///< diagonal of the bounding box of the feature
    /// Largest distance of a vertex from its original position mapped by the best-fit similarity
    /// transform, relative to `size`.
    double max_rigid_error = 0;
    /// Scale factor, rotation angle (degrees) and translation (model units) of the similarity
    /// transform that maps the original feature best to the deformed feature.
    double scale = 1, rotation_deg = 0, moved = 0;
  };
  std::vector<Feature> features;

  /// A chain of vertices whose positions a deformable curve prescribes.
  struct Curve {
    std::string name;
    int vertices = 0, segments = 0;
    Deviation fairing;  ///< distances of the original vertices from the faired curve, model units
    double wavelength = 0;
    double largest_shift = 0;  ///< largest displacement of the curve by its loads, model units
    double max_residual = 0;   ///< largest distance of a moved vertex from the curve / mesh size
    Fairness before, after;
  };
  std::vector<Curve> curves;

  /// A boundary loop of the mesh. `loop`: its number, as in the key `loop` of [[select]].
  struct Hole {
    int loop = 0, vertices = 0;
    std::string feature;  ///< name of the feature that contains the loop; empty: none
    HoleMeasure before, after;
  };
  std::vector<Hole> holes;

  /// A [[dimension]] before and after the edits.
  struct Dimension {
    std::string name, type;
    double before = 0, after = 0;
    std::string unit;                   ///< such as "mm", "mm²", "degrees"; empty: a mass
    std::vector<std::string> required;  ///< conditions of [[require]]: ">= 20"
  };
  std::vector<Dimension> dimensions;

  /// Distances from a [[target]] after the edits, model units.
  struct Target {
    std::string file;
    int followers = 0, ignored = 0;  ///< vertices that follow it; those without a point of it
    double rms = 0, largest = 0;     ///< from the vertices to the target, minus the offset
    double back_rms = 0, back_largest = 0;  ///< from the target to the mesh, minus the offset
    double smoothing = 0;                   ///< smoothing length that was used
  };
  std::vector<Target> targets;

  /// Variants of a design of experiments.
  struct Variants {
    int count = 0, failed = 0;  ///< all; those without a solution, or that violate checks
    std::string table;          ///< name of the table
  };
  std::optional<Variants> variants;

  /// Derivatives that were written.
  struct Derivatives {
    std::vector<std::string> files, parameters;
    double largest_error = 0;  ///< largest estimated relative error
  };
  std::optional<Derivatives> derivatives;

  /// Elements of a deck that are not shells, and how their nodes followed the shells.
  struct Attached {
    /// Number of elements per element type of the deck.
    std::vector<std::pair<std::string, int>> elements;
    /// Number of rigid elements, bushings and bolts, which move as rigid bodies.
    int connections = 0;
    /// Largest distance of a node of a connection from its position under the best-fit rigid-body
    /// motion of the connection, model units.
    double max_rigid_error = 0;
    std::string worst_connection;  ///< name of the connection with `max_rigid_error`
    int moved_with_shells = 0;     ///< number of moved nodes that belong to no shell or connection
    std::vector<long> inverted_solids;  ///< ids of inverted solid elements in the deck
  };
  Attached attached;

  QualitySummary before, after;
  std::vector<long> inverted;  ///< numbers of inverted faces in the mesh file
  /// Largest displacement of a node, and number of this node in the mesh file (-1: none moved).
  double largest_displacement = 0;
  long largest_displacement_node = -1;
  /// Largest rounding error of a written coordinate, model units.
  double rounding = 0;
};

/// Lists the checks that the measured numbers of a deformed mesh violate. The checks are:
/// - residuals and rigid errors of features are at most 1e-12, or 16 rounding errors of the largest
///   coordinate if that is more;
/// - no faces and no solid elements are inverted;
/// - MeshEditStatistics::last_correction is at most 1e-9;
/// - connections deviate from rigid-body motions by at most 1e-12 of the size of the mesh, or the
///   same rounding errors;
/// - all numbers are finite.
std::vector<FailedCheck> failed_checks(const DeformReport& report);

/// The report of a deformed mesh as JSON text. Numbers that are not finite become the strings "nan"
/// and "inf".
std::string to_json(const DeformReport& report);

}  // namespace batten
