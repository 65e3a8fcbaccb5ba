// report.json of a surface, measured on the finished result; also the reports of a stress analysis
// and of faired curves.
#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/io/report/network_report.h"
#include "batten/io/report/run_report.h"
#include "batten/sculpting/session/session_results.h"
#include "batten/skinning/region/skinned_region.h"

namespace batten {

// Results of a stress analysis.

/// Results of `batten stress`. Lengths are in the scene's unit; the units of forces and stresses
/// follow from the unit of Young's modulus.
struct StressReport {
  std::string material;  ///< its name; empty if the scene gives elastic constants instead
  int unknowns = 0;      ///< size of the factored system
  double yield = 0;      ///< yield stress; 0: not given
  /// Largest thickness divided by the smallest radius of curvature.
  double thickness_over_radius = 0;
  /// Largest edge length / √(radius · thickness). Above 1.5 the mesh is too coarse for the boundary
  /// layer.
  double edge_over_boundary_layer = 0;

  /// Rigid-body modes that the supports hardly constrain.
  std::vector<std::string> weakly_constrained_motions;
  /// Smallest lever arm (RMS) with which the supports resist one of these modes, divided by the
  /// size of the shell.
  double smallest_lever = 0;

  /// Resultant of the reactions at one support.
  struct Reaction {
    std::string support;
    Vec3 force, moment;  ///< acting on the shell; moment about the origin
  };
  /// Maxima of a CalculiX analysis of the same shell, and its values at our locations of the
  /// maxima.
  struct CalculixResult {
    std::string elements;
    double displacement = 0, stress = 0, displacement_there = 0, stress_there = 0;
  };
  /// One load case or combination.
  struct Case {
    std::string name;
    bool combination = false;
    Vec3 force = Vec3::Zero();      ///< resultant of all loads
    double displacement = 0;        ///< largest displacement
    double displacement_error = 0;  ///< estimated error of the largest displacement
    Vec3 displacement_vector = Vec3::Zero(), max_displacement_at = Vec3::Zero();
    std::string max_displacement_region;
    double stress = 0;                          ///< largest von Mises stress
    std::string side;                           ///< surface of that stress, "top" or "bottom"
    Vec3 max_stress_at = Vec3::Zero();          ///< location, on the middle surface
    Vec3 max_stress_face_point = Vec3::Zero();  ///< the same location on the top or bottom surface
    std::string max_stress_region;
    double spread = 0;  ///< spread of the unaveraged element stresses there
    /// True: next to a point load or support, where stresses are singular.
    bool near_singularity = false;
    double safety = 0;  ///< safety factor against yield, yield / stress; 0: no yield stress given
    double energy = 0;
    double error = 0;                 ///< estimated relative error in the energy norm
    double equilibrium_residual = 0;  ///< |loads + reactions| / |loads|
    bool buckling_requested = false;
    std::vector<double> buckling;  ///< buckling load factors, ascending
    std::vector<Reaction> reactions;
    std::optional<CalculixResult> calculix;
  };
  std::vector<Case> cases;
  /// One mesh of the refinement towards a requested accuracy, with the maxima over all load cases.
  struct Mesh {
    double edge_length = 0;
    int unknowns = 0;
    double displacement = 0, stress = 0;
    double error = 0;  ///< estimated relative error of the displacements
  };
  std::vector<Mesh> meshes;
  /// Derivatives of the results of a load case with respect to a parameter of the scene.
  struct Sensitivity {
    std::string parameter, load_case;
    double displacement = 0;  ///< d(largest displacement), in its direction
    double compliance = 0;    ///< d(work of the loads)
  };
  std::vector<Sensitivity> sensitivities;
  std::vector<double> frequencies;  ///< natural frequencies, 1/time; rigid-body modes first, as 0
};

/// Results of `batten run`, `skin` and `sculpt`. Lengths are in model units, angles in degrees;
/// *_residual is relative to the region's size.
struct Report : RunReport {
  /// A character line and its curve.
  struct Line {
    std::string name;
    CharacterLine::Role role = CharacterLine::Role::Outline;
    bool embedded = false;
    double length = 0;
    double deviation = 0;  ///< largest distance of the input from its curve
    int nodes = 0;
    int points = 0;  ///< embedded line: number of points that constrain the surface
    double gap = 0;  ///< embedded line: gap between curve and surface between those points
    bool constrains_surface = true;  ///< false: the curve only trims the surface, as its boundary
  };
  std::vector<Line> lines;
  std::vector<FairedLine> curves;          ///< curves faired by [[fair]]
  std::vector<std::string> reading_notes;  ///< remarks on how point files were interpreted

  /// The surface, or all surfaces of a network.
  struct Surface {
    int regions = 1, triangles = 0, dofs = 0;
    std::string element, boundary, fair;  ///< values of [skin] as in the scene
    SkinQuality quality;
    double size = 0, bending_energy = 0;
    double max_constraint_residual = 0, max_normal_constraint_deg = 0, max_smooth_join_deg = 0;
    int iterations = 0;
    double last_change = 0;
    /// For scenes with loads or constraints: largest distance of a vertex from the shape of the
    /// lines alone, model units.
    double moved = 0;
    /// Orientation of the normals as text (NormalSide::text()). For networks: the most frequent
    /// text of the shells, with its count.
    std::string normals;
    Vec3 mean_normal = Vec3::Zero();  ///< area-weighted mean of the unit normals
    /// Result of minimum-variation fairing.
    struct Fairing {
      double functional = 0, start_functional = 0;  ///< curvature variation, 1/length²
      double max_move = 0;  ///< largest normal displacement of a vertex, model units
      int iterations = 0, factorizations = 0;
      bool converged = false;
      /// Fraction of the step from the minimum-bending shape that was taken.
      double step_fraction = 1;
      std::vector<std::string> unchanged_regions;  ///< regions left in their minimum-bending shape
      /// false: chosen by fair = "auto" for regions with five or more sides.
      bool requested = true;
      int regions = 0;  ///< number of faired regions
    };
    std::optional<Fairing> fairing;
  } surface;
  std::vector<DefectReport> defects;     ///< defects of the surfaces
  std::optional<NetworkReport> network;  ///< set for scenes with a curve network

  /// Distances between the shape and [[target]], in both directions; model units.
  struct Target {
    std::vector<std::string> files;
    double tolerance = 0, size = 0;
    double before_rms = 0, before_max = 0;  ///< minimum-bending shape to target
    double rms = 0, max = 0;                ///< fitted shape to target
    double back_rms = 0, back_max = 0;      ///< target to fitted shape
    int points = 0, back_points = 0;        ///< number of measured points
    /// Points beyond a free edge of the other surface; not counted.
    int excluded = 0, back_excluded = 0;
    Vec3 where = Vec3::Zero();  ///< point of the fitted shape farthest from the target
    int iterations = 0, refinements = 0;
    bool reached = false;
    struct Line {
      std::string name;
      double distance = 0;
    };
    /// Lines whose distance from the target exceeds the tolerance.
    std::vector<Line> line_distances;
    std::vector<std::pair<std::string, double>> regions;  ///< largest distance per region
  };
  std::optional<Target> target;

  /// The STEP file.
  struct Step {
    std::string file, form;
    int faces = 0;
    /// "B-spline", "cylinder", …; "face" for the form "face".
    std::map<std::string, int> faces_by_kind;
    int lines = 0;         ///< number of curves written beside the faces
    double tolerance = 0;  ///< requested tolerance; 0: exact form
    int poles_u = 0, poles_v = 0;
    std::uintmax_t bytes = 0;
    double max_deviation = 0, max_gap = 0, max_normal_jump_deg = 0;
    bool valid = false;
    /// Edges of the file with two faces, by continuity: crease (G0), tangent (G1), curvature (G2).
    /// max_smooth_deg: largest angle at edges that are no creases.
    int creases = 0, tangent = 0, curvature = 0;
    double max_smooth_deg = 0;
    /// A smooth join of fitted faces: largest angle between the faces, and between the surfaces.
    struct Join {
      std::string line;
      std::array<std::string, 2> regions;
      double angle_deg = 0, surface_deg = 0;
      bool exceeds_tolerance = false;
      std::string why;  ///< reason for an angle that is not a defect of the file; empty otherwise
    };
    std::vector<Join> joins;
    double max_join_deg = 0;
    // For networks only:
    int shells = 0, solids = 0, free_edges = 0;
    double volume = 0;
  };
  std::optional<Step> step;  ///< the STEP file, measured after reading it back

  /// Distances of evenly sampled surface points from the faces of a CAD file.
  struct Comparison {
    std::string file;
    int points = 0;
    double max = 0, rms = 0;  ///< model units
    /// Relative to the longest side of the lines' bounding box.
    double max_relative = 0, rms_relative = 0;
  };
  std::optional<Comparison> comparison;

  std::vector<Reaction> reactions;  ///< reaction of each named constraint

  /// Integral quantities of the shape in a sculpting session.
  struct Shape {
    double stretching = 0, bending = 0;  ///< the two terms of SurfaceEnergy
    double area = 0, volume = 0;         ///< model units² and ³; the volume is ⅓ ∬ x·n dA
    double residual = 0;                 ///< largest residual of all constraints
  };
  /// Results of `batten sculpt`.
  struct Sculpting {
    Shape shape;  ///< the final shape
    struct Step {
      std::string what;  ///< the operation: "solve", "replay", …
      int iterations = 0;
      double change = 0;
      bool factored = false;
    };
    std::vector<Step> solves;
    /// One refinement of the mesh.
    struct Refinement {
      int triangles_before = 0, triangles = 0;
      double max_displacement = 0, energy_before = 0, energy_transferred = 0,
             energy_at_equilibrium = 0;
    };
    std::vector<Refinement> refinements;
    /// Maxima over all load cases of [stress].
    struct Stress {
      double displacement = 0, von_mises = 0;
    };
    /// One value of a sweep, or one frame of a motion.
    struct Row {
      double value = 0;  ///< value of the parameter, or time
      Shape shape;
      int iterations = 0;            ///< sweeps: solver iterations
      double total_energy = 0;       ///< motions: kinetic and potential energy
      std::optional<Stress> stress;  ///< sweeps: set if requested
    };
    struct Sweep {
      std::string parameter;
      std::vector<Row> rows;
      std::string stopped;  ///< why the sweep ended early; empty: it did not
    };
    std::vector<Sweep> sweeps;
    /// Result of a dynamic motion.
    struct Motion {
      double dt = 0, density = 0, damping = 0, theta = 0;
      int steps = 0;
      double max_residual = 0;  ///< largest residual of all steps
      std::vector<Row> rows;    ///< one per frame
    };
    std::optional<Motion> motion;
  };
  std::optional<Sculpting> sculpting;  ///< set by `batten sculpt`
  std::optional<StressReport> stress;  ///< set by `batten stress`
  bool is_sculpted = false;            ///< Scene::is_sculpted(); not written to the file
  std::vector<PointCloudDistances> scans;
};

/// Numbers of the report that are not finite, by their JSON path ("surface.area").
std::vector<FailedCheck> non_finite_numbers(const Report& report);

/// The report as JSON text. Numbers that are not finite, which JSON cannot represent, become the
/// strings "nan" and "inf". Append non_finite_numbers() to `failed_checks` before calling it.
std::string to_json(const Report& report);

// report.json of faired curves, measured on the curves that are written.

/// Results of `batten fair`.
struct FairReport : RunReport {
  std::vector<FairedLine> curves;
};

/// Acceptance checks that the reported numbers violate: failed_fairing_checks(), and numbers that
/// are not finite.
std::vector<FailedCheck> failed_checks(const FairReport& report);
/// Violated fairing checks: stages whose requested deviation is exceeded, and conditions with a
/// residual above 1e-12 of the curve's size.
std::vector<FailedCheck> failed_fairing_checks(const std::vector<FairedLine>& curves);

/// The report as JSON text. Numbers that are not finite become the strings "nan" and "inf".
std::string to_json(const FairReport& report);

}  // namespace batten
