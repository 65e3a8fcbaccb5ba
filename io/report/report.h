// SPDX-License-Identifier: MPL-2.0
// Contents of report.json for a surface (measured on the finished result), for a stress analysis
// and for faired curves.
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
#include "batten/skinning/surfaces/fitted_primitive.h"

namespace batten {

// Results of a stress analysis.

/// Results of `batten stress`. Lengths are in the unit of the scene; the units of forces and
/// stresses follow from the unit of Young's modulus.
struct StressReport {
  std::string material;  ///< name of the material; empty: the scene gives elastic constants
  int unknowns = 0;      ///< number of unknowns of the factored linear system
  double yield = 0;      ///< yield stress; 0: not given
  /// Largest ratio of the thickness of the shell to its smallest radius of curvature.
  double thickness_over_radius = 0;
  /// Largest ratio of the length of an element edge to √(radius of curvature · thickness). If this
  /// ratio exceeds 1.5, the mesh is too coarse to resolve boundary layers.
  double edge_over_boundary_layer = 0;

  /// Descriptions of rigid-body modes that the supports hardly constrain.
  std::vector<std::string> weakly_constrained_motions;
  /// Smallest lever arm (RMS) with which the supports resist a weakly constrained mode, relative to
  /// the size of the shell.
  double smallest_lever = 0;

  /// Resultant of the reactions at one support.
  struct Reaction {
    std::string support;
    Vec3 force, moment;  ///< force and moment on the shell (moment about the origin)
  };
  /// Results of a CalculiX analysis of the same shell: its maxima, and its values at the points
  /// where Batten found its own maxima (`displacement_there`, `stress_there`).
  struct CalculixResult {
    std::string elements;
    double displacement = 0, stress = 0, displacement_there = 0, stress_there = 0;
    std::vector<double> buckling;  ///< factors, if requested
  };
  /// Results of one load case, or of one combination of load cases.
  struct Case {
    std::string name;
    bool combination = false;
    Vec3 force = Vec3::Zero();      ///< resultant force of all loads
    double displacement = 0;        ///< largest displacement
    double displacement_error = 0;  ///< estimated error of `displacement`
    Vec3 displacement_vector = Vec3::Zero(), max_displacement_at = Vec3::Zero();
    std::string max_displacement_region;
    double stress = 0;  ///< largest von Mises stress
    std::string side;   ///< side of the shell with the largest stress, "top" or "bottom"
    Vec3 max_stress_at = Vec3::Zero();  ///< point of the middle surface with the largest stress
    /// Point on the top or bottom side of the shell with the largest stress.
    Vec3 max_stress_face_point = Vec3::Zero();
    std::string max_stress_region;
    /// Largest deviation of unaveraged element stresses around max_stress_at from `stress`.
    double spread = 0;
    /// True if the largest stress is next to a point load or support, where stresses are singular.
    bool near_singularity = false;
    /// A ball around a singular stress, outside of which `stress` is the largest one.
    struct SingularPlace {
      Vec3 at = Vec3::Zero();
      double radius = 0;
    };
    std::vector<SingularPlace> singular_places;
    double safety = 0;  ///< safety factor against yield, yield / stress; 0: no yield stress given
    int ply = 0;        ///< ply with the largest stress, from 1, from the bottom; 0: no laminate
    /// The smallest factor by which the stress in a ply can grow until a failure criterion is met.
    struct Reserve {
      std::string criterion;  ///< "Tsai-Hill" or "Hoffman"
      double factor = 0;
      int ply = 1;  ///< from 1, from the bottom
      Vec3 at = Vec3::Zero();
      std::string region;
    };
    std::vector<Reserve> reserves;  ///< empty: no material has strengths
    double energy = 0;
    double error = 0;  ///< estimated relative error of the solution in the energy norm
    /// Sum of the forces of loads and supports, relative to the sum of their magnitudes, or the same
    /// for their moments, whichever is larger.
    double equilibrium_residual = 0;
    /// Estimated relative change of the displacements by large displacements, and by transverse shear
    /// (analysis/models/theory_limits.h).
    double nonlinearity = 0, shear_share = 0;
    /// Values that were requested at a point, along a curve, or on a face.
    struct Result {
      struct Range {
        double least = 0, mean = 0, largest = 0;
      };
      struct Point {
        Vec3 at = Vec3::Zero(), displacement = Vec3::Zero();
        std::string face;
        /// At the top, in the middle and at the bottom: von Mises and principal stresses.
        std::vector<double> von_mises;
        std::vector<std::array<double, 2>> principal;
        std::vector<Vec3> principal_directions;  ///< of the larger principal stress
        double membrane = 0, bending = 0;        ///< von Mises stresses of the linearised stress
        /// Components about the axis of the result at the top, in the middle and at the bottom.
        std::vector<double> hoop, meridional, shear;
        Mat3 forces = Mat3::Zero(), moments = Mat3::Zero();
      };
      std::string name, kind;      ///< kind: "point", "curve" or "face"
      std::optional<Point> point;  ///< of a point; the following ones are of curves and faces
      double size = 0;             ///< length or area
      Range displacement, von_mises;
    };
    std::vector<Result> results;
    /// Largest values of a stiffener: axial stress of a fibre; axial force, bending moments and torque
    /// with their signs, least and largest.
    struct StiffenerValues {
      std::string name;
      double stress = 0;
      Vec3 at = Vec3::Zero();
      std::array<double, 2> axial, bending, lateral_bending, torque;
    };
    std::vector<StiffenerValues> stiffeners;
    /// Largest amplitude of a point in a steady vibration under this load.
    struct Vibration {
      std::string point;  ///< name of the result, or "largest displacement"
      double frequency = 0, amplitude = 0;
    };
    std::vector<Vibration> vibrations;
    bool buckling_requested = false;
    std::vector<double> buckling;  ///< buckling load factors, ascending
    std::vector<Reaction> reactions;
    std::optional<CalculixResult> calculix;
  };
  std::vector<Case> cases;
  /// Largest response to a spectrum of accelerations of the supports, at the vertices of the mesh.
  struct Spectrum {
    int modes = 0;
    double mass_fraction = 0;  ///< part of the mass that belongs to these modes
    double displacement = 0, stress = 0;
    Vec3 displacement_at = Vec3::Zero(), stress_at = Vec3::Zero();
    std::string displacement_region, stress_region;
    struct Point {
      std::string name;
      Vec3 displacement;
      double von_mises;
    };
    std::vector<Point> points;        ///< of the requested results at points
    std::vector<Reaction> reactions;  ///< absolute values
  };
  std::optional<Spectrum> spectrum;
  std::vector<double> calculix_frequencies;  ///< elastic modes by CalculiX, if requested
  /// One mesh of an adaptive refinement, with the maxima over all load cases.
  struct Mesh {
    double edge_length = 0;
    int unknowns = 0;
    double displacement = 0, stress = 0;
    double error = 0;         ///< estimated relative error of the displacements
    double stress_error = 1;  ///< estimated relative error of the largest stresses
  };
  std::vector<Mesh> meshes;
  /// Derivatives of results of a load case with respect to a parameter of the scene.
  struct Sensitivity {
    std::string parameter, load_case;
    double displacement = 0;  ///< derivative of the largest displacement
    double compliance = 0;    ///< derivative of the compliance (work of the loads)
  };
  std::vector<Sensitivity> sensitivities;
  /// Natural frequencies, 1/time. Rigid-body modes come first, with frequency 0.
  std::vector<double> frequencies;
  /// Per frequency: participation factors for accelerations along x, y and z of modes with the
  /// modal mass 1; their squares are the effective masses.
  std::vector<Vec3> participation;
  double mass = 0;  ///< mass of the shell; 0: no modes requested
};

/// Results of `batten run`, `batten skin` and `batten sculpt`. Lengths are in model units, angles
/// in degrees. A `…_residual` is relative to the size of the face.
struct Report : RunReport {
  /// A curve of the scene, and how well the fitted curve follows it.
  struct Line {
    std::string name;
    CharacterLine::Role role = CharacterLine::Role::Outline;
    bool embedded = false;
    double length = 0;
    double deviation = 0;  ///< largest distance of the input curve from the fitted curve
    int nodes = 0;
    int points = 0;  ///< embedded curves: number of points at which the surface is constrained
    double gap = 0;  ///< embedded curves: largest distance between the curve and the surface
    /// False: the curve trims the surface but does not constrain it.
    bool constrains_surface = true;
  };
  std::vector<Line> lines;
  std::vector<FairedLine> curves;          ///< curves that were faired by [[fair]] stages
  std::vector<std::string> reading_notes;  ///< notes on how curve files were interpreted

  /// Results for the surface of the scene. For a curve network: totals and extremes over all faces.
  struct Surface {
    int regions = 1, triangles = 0, dofs = 0;
    std::string element, boundary, fair;  ///< values of the keys of the same names in [skin]
    SkinQuality quality;
    double size = 0, bending_energy = 0;
    double max_constraint_residual = 0, max_normal_constraint_deg = 0, max_smooth_join_deg = 0;
    int iterations = 0;
    double last_change = 0;
    /// Largest displacement of a vertex from the shape that the curves alone define, in model
    /// units. Set for scenes with loads or constraints.
    double moved = 0;
    /// Orientation of the normals as text (NormalSide::text()). For a network with several shells:
    /// the most frequent orientation, with the number of shells that have it.
    std::string normals;
    Vec3 mean_normal = Vec3::Zero();  ///< area-weighted mean of the unit normals
    /// Result of fairing to a minimum-variation surface.
    struct Fairing {
      /// Integral of the squared curvature variation after and before fairing, 1/length².
      double functional = 0, start_functional = 0;
      double max_move = 0;  ///< largest displacement of a vertex along the normal, model units
      int iterations = 0, factorizations = 0;
      bool converged = false;
      /// Interpolation parameter of the result between the minimum-bending shape (0) and the
      /// minimum-variation shape (1).
      double step_fraction = 1;
      /// Names of the faces that keep their minimum-bending shape.
      std::vector<std::string> unchanged_regions;
      /// True: the scene requests fairing. False: fairing was chosen automatically (fair = "auto")
      /// for faces with five or more sides.
      bool requested = true;
      int regions = 0;  ///< number of faired faces
    };
    std::optional<Fairing> fairing;
  } surface;
  std::vector<DefectReport> defects;     ///< defects of the surfaces
  std::optional<NetworkReport> network;  ///< set if the scene has a curve network

  /// Distances between the shape and the [[target]] surface, in both directions; model units.
  struct Target {
    std::vector<std::string> files;
    double tolerance = 0, size = 0;
    /// Distances of the minimum-bending shape from the target.
    double before_rms = 0, before_max = 0;
    double rms = 0, max = 0;            ///< distances of the fitted shape from the target
    double back_rms = 0, back_max = 0;  ///< distances of the target from the fitted shape
    int points = 0, back_points = 0;    ///< number of sample points on the shape, and on the target
    /// Number of sample points on the shape, and on the target, that are not counted because they
    /// lie beyond a free edge of the other surface.
    int excluded = 0, back_excluded = 0;
    Vec3 where = Vec3::Zero();  ///< point of the fitted shape that is farthest from the target
    int iterations = 0, refinements = 0;
    bool reached = false;
    bool analytic = false;                              ///< ModelFit::analytic
    std::map<std::string, FittedPrimitive> primitives;  ///< of targets, by the name of the face
    struct Line {
      std::string name;
      double distance = 0;
    };
    /// Curves whose distance from the target exceeds the tolerance.
    std::vector<Line> line_distances;
    /// Largest distance from the target per face.
    std::vector<std::pair<std::string, double>> regions;
  };
  std::optional<Target> target;

  /// Measurements of the STEP file that was written.
  struct Step {
    std::string file, form;
    int faces = 0;
    /// Number of faces per surface type ("B-spline", "cylinder", …). The type is "face" if `form`
    /// is "face".
    std::map<std::string, int> faces_by_kind;
    /// Name of the CAD file whose own faces the STEP file contains; empty: the faces were made from
    /// the model.
    std::string source = "";
    /// The given faces ([[neighbour]]) that the STEP file also contains: their number and file, and
    /// the edges between them and the faces of the model.
    struct Neighbours {
      std::string file;
      int faces = 0, edges = 0;
      int smooth_edges = 0;  ///< number of `edges` at which the faces are tangent (0.1 degrees)
      double max_gap = 0;    ///< largest distance between the two faces at an edge, model units
      double max_smooth_deg = 0;  ///< largest angle at the smooth edges of the model, degrees
    };
    std::optional<Neighbours> neighbours = {};
    int lines = 0;         ///< number of curves written in addition to the faces
    double tolerance = 0;  ///< requested tolerance of fitted faces, model units; 0: exact faces
    int poles_u = 0, poles_v = 0;
    std::uintmax_t bytes = 0;
    double max_deviation = 0, max_gap = 0, max_normal_jump_deg = 0;
    bool valid = false;
    /// Number of edges between two faces, per continuity: creases (G0), tangent edges (G1),
    /// curvature-continuous edges (G2).
    int creases = 0, tangent = 0, curvature = 0;
    /// Largest angle between the two faces at an edge that is not a crease, degrees.
    double max_smooth_deg = 0;
    /// A smooth edge shared by fitted faces, with the largest angle between the faces in the file
    /// (`angle_deg`) and between the original surfaces (`surface_deg`).
    struct Join {
      std::string line;
      std::array<std::string, 2> regions;
      double angle_deg = 0, surface_deg = 0;
      bool exceeds_tolerance = false;
      /// Reason why an angle above the tolerance is not a defect of the file; empty: no such
      /// reason.
      std::string why;
    };
    std::vector<Join> joins;
    double max_join_deg = 0;
    // Set for curve networks only:
    int shells = 0, solids = 0, free_edges = 0;
    double volume = 0;
  };
  /// The mesh of the surface ([output] mesh), joined to given meshes ([[neighbour]]).
  struct Mesh {
    std::string file;
    int faces = 0;         ///< number of faces of the file
    int given_faces = 0;   ///< of them, those of given meshes
    int joined_loops = 0;  ///< boundary loops of given meshes that share their nodes with new faces
    int free_edges = 0;    ///< number of edges with one face
  };
  std::optional<Mesh> mesh;
  std::optional<Step> step;  ///< measured after reading the file back; empty: no STEP file

  /// Distances of uniformly distributed surface points from the faces of a CAD file.
  struct Comparison {
    std::string file;
    int points = 0;
    double max = 0, rms = 0;  ///< largest and RMS distance, model units
    /// Largest and RMS distance, relative to the longest side of the bounding box of the curves.
    double max_relative = 0, rms_relative = 0;
  };
  std::optional<Comparison> comparison;

  std::vector<Reaction> reactions;  ///< reaction force of each named constraint

  /// Integrals over the shape in a sculpting session.
  struct Shape {
    double stretching = 0, bending = 0;  ///< stretching and bending energy (see SurfaceEnergy)
    double area = 0, volume = 0;  ///< area and volume ⅓ ∬ x·n dA, in powers of the model unit
    double residual = 0;          ///< largest constraint residual
  };
  /// Results of `batten sculpt`.
  struct Sculpting {
    Shape shape;  ///< integrals over the final shape
    struct Step {
      std::string what;  ///< operation of the session: "solve", "replay", …
      int iterations = 0;
      double change = 0;
      bool factored = false;
    };
    std::vector<Step> solves;
    /// One mesh refinement, with the elastic energy before the refinement, after the transfer to
    /// the new mesh, and in equilibrium on the new mesh.
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
    /// Results for one parameter value of a sweep, or for one frame of a dynamic simulation.
    struct Row {
      double value = 0;  ///< parameter value of the sweep, or time of the frame
      Shape shape;
      int iterations = 0;            ///< sweeps only: number of solver iterations
      double total_energy = 0;       ///< dynamic simulations only: kinetic + potential energy
      std::optional<Stress> stress;  ///< sweeps only: set if [stress] was requested
    };
    struct Sweep {
      std::string parameter;
      std::vector<Row> rows;
      std::string stopped;  ///< reason why the sweep stopped early; empty: it was completed
    };
    std::vector<Sweep> sweeps;
    /// Result of a dynamic simulation.
    struct Motion {
      double dt = 0, density = 0, damping = 0, theta = 0;
      int steps = 0;
      double max_residual = 0;  ///< largest constraint residual over all time steps
      std::vector<Row> rows;    ///< results of each frame
    };
    std::optional<Motion> motion;
  };
  std::optional<Sculpting> sculpting;  ///< set by `batten sculpt`
  std::optional<StressReport> stress;  ///< set by `batten stress`
  bool is_sculpted = false;  ///< Scene::is_sculpted() of the scene; not written to report.json
  std::vector<PointCloudDistances> scans;
};

/// Lists the numbers of the report that are NaN or infinite, by their JSON path ("surface.area").
std::vector<FailedCheck> non_finite_numbers(const Report& report);

/// Lists the checks that the measured numbers of a report violate, and all numbers that are not
/// finite. The checks are, by sections of report.json:
///
///   faired_curves  residual of the conditions of [[fair]] ≤ 1e-12 of the size of the curve;
///                  requested deviation not exceeded
///   curves         distance of the input from the fitted curve ≤ tolerance
///   surface        constraint residual ≤ 1e-10 of the size of the face; error of prescribed
///                  normals ≤ 1e-6°; angle between normals across mesh edges ≤ 1e-3°; Jacobian ≥
///                  0.05 of its median; no singular nodes. If the curves are fixed: residual of
///                  edge-aligned curves ≤ 1e-10, gap of embedded curves ≤ tolerance, deviation of
///                  curves ≤ tolerance. If the scene requests a minimum-variation surface: its
///                  iteration converged
///   defects        no surface has a defect (SurfaceDefect)
///   step           exact faces: valid file; gap and (for HCT surfaces) deviation ≤ 1e-9 of the
///                  size plus the tolerance of the STEP file; angle between normals ≤ 1e-3°
///                  fitted faces (form "face"): valid file; deviation ≤ the tolerance of the STEP
///                  file; if the curves are fixed, gap ≤ that tolerance plus `tolerance`
///
/// For a network, the checks of `surface` apply to each face, where the permitted deviation of the
/// curves is larger by the gap tolerance with which the curves were joined. Further checks are:
///
///   faces          each face has a surface
///   joins          the angle at each smooth edge ≤ join tolerance (plus 0.05° under loads and
///                  offsets), except at ends at which the curves define no common tangent plane;
///                  every edge that was requested as smooth is smooth
///
/// `tolerance`: fit tolerance of the curves, model units.
std::vector<FailedCheck> failed_checks(const Report& report, double tolerance);

/// The report of a surface as JSON text. Numbers that are not finite, which JSON cannot represent,
/// become the strings "nan" and "inf". Before the call, append the result of non_finite_numbers()
/// to `report.failed_checks`.
std::string to_json(const Report& report);
/// The section "stress" of a report as JSON text, and its numbers that are NaN or infinite.
std::string to_json(const StressReport& stress);
std::vector<FailedCheck> non_finite_numbers(const StressReport& stress);

// Contents of report.json for faired curves, measured on the curves that are written.

/// Results of `batten fair`.
struct FairReport : RunReport {
  std::vector<FairedLine> curves;
};

/// Lists the violated checks of failed_fairing_checks(), and the numbers that are not finite.
std::vector<FailedCheck> failed_checks(const FairReport& report);
/// Lists the violated checks of faired curves: fairing stages that exceed their requested
/// deviation, and conditions whose residual exceeds 1e-12 of the size of the curve.
std::vector<FailedCheck> failed_fairing_checks(const std::vector<FairedLine>& curves);

/// The report of faired curves as JSON text. Numbers that are not finite become the strings "nan"
/// and "inf".
std::string to_json(const FairReport& report);

}  // namespace batten
