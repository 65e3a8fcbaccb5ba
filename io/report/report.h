// report.json of a surface: what was made, measured on the finished result.
#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "batten/io/report/network_report.h"
#include "batten/io/report/run_report.h"
#include "batten/sculpting/session/session_results.h"
#include "batten/skinning/region/skinned_region.h"
#include "batten/core/eigen.h"

namespace batten {

// What a stress analysis found, for report.json and for a mail.

/// Of `batten stress`. Units are the scene's: lengths in model units, forces and stresses follow
/// from Young's modulus.
struct StressReport {
  std::string material;  ///< its name, or ""
  int unknowns = 0;      ///< of the system that was factored
  double yield = 0;      ///< 0: not stated
  double thickness_over_radius =
      0;  ///< the largest thickness over the smallest radius of curvature
  double edge_over_boundary_layer =
      0;  ///< largest of edge length / √(radius · thickness): above 1.5 coarse

  std::vector<std::string> weakly_constrained_motions;  ///< which the supports hardly resist
  double smallest_lever = 0;                            ///< by what lever, over the size

  struct Reaction {
    std::string support;
    Vec3 force, moment;  ///< on the shell; moment about the origin
  };
  /// The largest values of another program on the same shell, and those where ours are largest.
  struct CalculixResult {
    std::string elements;
    double displacement = 0, stress = 0, displacement_there = 0, stress_there = 0;
  };
  struct Case {
    std::string name;
    bool combination = false;
    Vec3 force = Vec3::Zero();      ///< sum of all loads
    double displacement = 0;        ///< the largest
    double displacement_error = 0;  ///< estimate of what is missing of it
    Vec3 displacement_vector = Vec3::Zero(), max_displacement_at = Vec3::Zero();
    std::string max_displacement_region;
    double stress = 0;                          ///< the largest equivalent stress (von Mises)
    std::string side;                           ///< "top" or "bottom"
    Vec3 max_stress_at = Vec3::Zero();          ///< on the middle surface
    Vec3 max_stress_face_point = Vec3::Zero();  ///< the same place, top or bottom
    std::string max_stress_region;
    double spread = 0;  ///< of the elements' own stresses there
    bool near_singularity =
        false;          ///< beside a point load or support, where stresses have no limit
    double safety = 0;  ///< yield / stress; 0 where no yield is stated
    double energy = 0;
    double error = 0;                 ///< estimate, relative, in energy norm
    double equilibrium_residual = 0;  ///< |loads + reactions| / |loads|
    bool buckling_requested = false;
    std::vector<double> buckling;  ///< factors of the load, smallest first
    std::vector<Reaction> reactions;
    std::optional<CalculixResult> calculix;
  };
  std::vector<Case> cases;
  /// A mesh on the way to an accuracy that was asked for: the largest values of all cases.
  struct Mesh {
    double edge_length = 0;
    int unknowns = 0;
    double displacement = 0, stress = 0;
    double error = 0;  ///< estimate: relative, of displacements
  };
  std::vector<Mesh> meshes;
  /// Derivatives of a case by a parameter of the scene.
  struct Sensitivity {
    std::string parameter, load_case;
    double displacement = 0;  ///< of the largest displacement, along itself
    double compliance = 0;    ///< of the work of the loads
  };
  std::vector<Sensitivity> sensitivities;
  std::vector<double> frequencies;  ///< 1/time, rigid motions as 0 first
};


/// What `batten run`, `skin` and `sculpt` made. Lengths are in model units, *_residual over the
/// region's size, angles in degrees.
struct Report : RunReport {
  struct Line {
    std::string name;
    CharacterLine::Role role = CharacterLine::Role::Outline;
    bool embedded = false;
    double length = 0;
    double deviation = 0;  ///< largest deviation of the input from its curve
    int nodes = 0;
    int points = 0;  ///< of an embedded line: number of points where the surface is held
    double gap = 0;  ///< of an embedded line: gap between these points
    bool constrains_surface = true;  ///< false: it only trims the surface, whose rim its curve is
  };
  std::vector<Line> lines;
  std::vector<FairedLine> curves;          ///< the lines that [[fair]] faired
  std::vector<std::string> reading_notes;  ///< what one may not expect of how points were read

  struct Surface {
    int regions = 1, triangles = 0, dofs = 0;
    std::string element, boundary, fair;  ///< words of [skin]
    SkinQuality quality;
    double size = 0, bending_energy = 0;
    double max_constraint_residual = 0, max_normal_constraint_deg = 0, max_smooth_join_deg = 0;
    int iterations = 0;
    double last_change = 0;
    /// Of a scene in which something acts: the largest distance of a vertex from where the lines
    /// alone put it, model units.
    double moved = 0;
    /// Where the normals point, in words (NormalSide::text()); of a network what most of its shells
    /// say, with the number of those that say so.
    std::string normals;
    Vec3 mean_normal = Vec3::Zero();  ///< of the unit normals over the area
    /// What least variation did.
    struct Fairing {
      double functional = 0, start_functional = 0;  ///< change of curvature, 1/length²
      double max_move = 0;  ///< largest normal move of a vertex, model units
      int iterations = 0, factorizations = 0;
      bool converged = false;
      double step_fraction = 1;  ///< of the way from the bending shape that was gone
      std::vector<std::string> unchanged_regions;  ///< regions that keep their bending shape
      bool requested = true;  ///< false: of regions with five sides or more, by fair = "auto"
      int regions = 0;        ///< how many were faired
    };
    std::optional<Fairing> fairing;
  } surface;
  std::vector<DefectReport> defects;     ///< of the surface
  std::optional<NetworkReport> network;  ///< set for a scene with [network]

  /// How near the shape is to [[target]], both ways; model units.
  struct Target {
    std::vector<std::string> files;
    double tolerance = 0, size = 0;
    double before_rms = 0, before_max = 0;  ///< of the shape that bends least, to the target
    double rms = 0, max = 0;                ///< of the fitted one
    double back_rms = 0, back_max = 0;      ///< from the target to the fitted one
    int points = 0, back_points = 0;        ///< that were measured
    int excluded = 0, back_excluded = 0;    ///< beyond a rim of the other one: they do not count
    Vec3 where = Vec3::Zero();              ///< where the fitted one is farthest from it
    int iterations = 0, refinements = 0;
    bool reached = false;
    struct Line {
      std::string name;
      double distance = 0;
    };
    std::vector<Line>
        line_distances;  ///< lines that are themselves farther from it than the tolerance
    std::vector<std::pair<std::string, double>> regions;  ///< each one's largest distance
  };
  std::optional<Target> target;

  struct Step {
    std::string file, form;
    int faces = 0;
    std::map<std::string, int> faces_by_kind;  ///< "B-spline", "cylinder", …; in the form "face"
    int lines = 0;                             ///< curves beside the faces
    double tolerance = 0;                      ///< the tolerance asked for; 0 in the exact form
    int poles_u = 0, poles_v = 0;
    std::uintmax_t bytes = 0;
    double max_deviation = 0, max_gap = 0, max_normal_jump_deg = 0;
    bool valid = false;
    /// Edges of the file with two faces, by how these meet, and the largest angle of those that are no
    /// creases.
    int creases = 0, tangent = 0, curvature = 0;
    double max_smooth_deg = 0;
    /// Smooth joins of fitted faces, by line; the largest angle between faces and between surfaces.
    struct Join {
      std::string line;
      std::array<std::string, 2> regions;
      double angle_deg = 0, surface_deg = 0;
      bool exceeds_tolerance = false;
      std::string why;  ///< of an angle that is no miss of the file; else ""
    };
    std::vector<Join> joins;
    double max_join_deg = 0;
    // Written for a network only.
    int shells = 0, solids = 0, free_edges = 0;
    double volume = 0;
  };
  std::optional<Step> step;  ///< the STEP file, measured on the file read back

  /// Distances of the surface, sampled evenly, from the faces of a CAD file.
  struct Comparison {
    std::string file;
    int points = 0;
    double max = 0, rms = 0;                    ///< model units
    double max_relative = 0, rms_relative = 0;  ///< over the longest side of the lines' box
  };
  std::optional<Comparison> comparison;

  std::vector<Reaction> reactions;  ///< reaction of each named constraint

  /// Numbers that a sculpting session measures of its shape.
  struct Shape {
    double stretching = 0, bending = 0;  ///< the two parts of SurfaceEnergy
    double area = 0, volume = 0;         ///< model units² and ³; the volume is ⅓ ∬ x·n dA
    double residual = 0;                 ///< largest residual of all constraints
  };
  struct Sculpting {
    Shape shape;  ///< the shape in the end
    struct Step {
      std::string what;  ///< "settle", "replay", …
      int iterations = 0;
      double change = 0;
      bool factored = false;
    };
    std::vector<Step> solves;
    struct Refinement {
      int triangles_before = 0, triangles = 0;
      double max_displacement = 0, energy_before = 0, energy_transferred = 0,
             energy_at_equilibrium = 0;
    };
    std::vector<Refinement> refinements;
    /// Largest values of all load cases of [stress].
    struct Stress {
      double displacement = 0, von_mises = 0;
    };
    struct Row {
      double value = 0;  ///< value of the parameter, or time
      Shape shape;
      int iterations = 0;            ///< iterations, in a sweep
      double total_energy = 0;       ///< kinetic and potential energy, in a motion
      std::optional<Stress> stress;  ///< in a sweep, where asked for
    };
    struct Sweep {
      std::string parameter;
      std::vector<Row> rows;
      std::string stopped;  ///< why the sweep ended early; "" when it did not
    };
    std::vector<Sweep> sweeps;
    struct Motion {
      double dt = 0, density = 0, damping = 0, theta = 0;
      int steps = 0;
      double max_residual = 0;  ///< largest residual of all steps
      std::vector<Row> rows;    ///< one row for each frame
    };
    std::optional<Motion> motion;
  };
  std::optional<Sculpting> sculpting;  ///< set by `batten sculpt`
  std::optional<StressReport> stress;  ///< set by `batten stress`
  bool is_sculpted = false;            ///< Scene::is_sculpted(); not in the file
  std::vector<PointCloudDistances> scans;
};

/// The numbers of the report that are not finite, by their names in the file ("surface.area").
std::vector<FailedCheck> non_finite_numbers(const Report& report);

/// The report as JSON text. A number that is not finite, which JSON cannot hold, becomes the word
/// "nan" or "inf". Add non_finite_numbers() to `exceeds_tolerance` before.
std::string to_json(const Report& report);


// report.json of faired curves: measured on the curves that are written.

/// What `batten fair` did.
struct FairReport : RunReport {
  std::vector<FairedLine> curves;
};

/// The promises that the report's own numbers break: those of failed_fairing_checks(), and numbers that
/// are not finite.
std::vector<FailedCheck> failed_checks(const FairReport& report);
/// Deviations that a stage states and does not keep, and conditions with a residual above 1e-12 of
/// the line's size.
std::vector<FailedCheck> failed_fairing_checks(const std::vector<FairedLine>& curves);

/// The report as JSON text. Numbers that are not finite become the words "nan" and "inf".
std::string to_json(const FairReport& report);

}  // namespace batten
