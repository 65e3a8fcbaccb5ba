// SPDX-License-Identifier: MPL-2.0
// Stress analysis of a model in memory: a thin shell, its supports and its loads.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/core/geometry.h"
#include "batten/core/progress.h"
#include "batten/scenes/gradients.h"
#include "batten/scenes/model.h"

namespace batten {

namespace detail {
struct StressData;  // scenes/stress_data.h
}

/// A support of a shell, with the keys and defaults of `supports` in docs/stress.md: at a curve, at
/// the surface point nearest to a point, on a face, or in a box; a box can also limit a curve or a
/// face.
struct ShellSupport {
  std::string curve = {};
  std::optional<Vec3> point = {};
  std::string face = {};
  std::optional<Box3> box = {};
  /// "clamped", "pinned", "symmetric" or "prescribed"; empty: "clamped", at a point "pinned", with
  /// `directions` "prescribed".
  std::string type = {};
  std::vector<Vec3> directions = {};      ///< constrained directions of a prescribed support
  std::optional<Vec3> normal = {};        ///< normal of the plane of a symmetric support
  std::optional<bool> rotation = {};      ///< whether the rotation about the curve is constrained
  std::optional<Vec3> displacement = {};  ///< prescribed displacement, model units
  /// Stiffness of springs along x, y, z: per length of the curve, of one spring at a point, or per
  /// area of a face.
  std::optional<Vec3> spring = {};
  double foundation = 0;  ///< stiffness per area along the normal, above 0; 0: none
};

/// A load on a shell, with the keys of `loads` in docs/stress.md. Set one value (or both totals, or
/// both temperatures), and the place that it needs.
struct ShellLoad {
  std::optional<double> pressure = {};  ///< force per area along the normal
  std::optional<Vec3> traction = {};    ///< force per area
  std::optional<Vec3> gravity = {};     ///< acceleration; needs a density
  /// Increase of the hydrostatic pressure per length below z = `level`, along the normal.
  std::optional<double> hydrostatic = {};
  std::optional<Vec3> force = {};     ///< force at `point`, or force per length along `curve`
  std::optional<double> moment = {};  ///< moment per length about the direction of `curve`
  /// Force per length on `curve`, an edge of one face: in the tangent plane, away from the face.
  std::optional<double> edge_force = {};
  /// Force and moment about the centroid, spread over `curve`, `face`, `box` or the whole surface.
  std::optional<Vec3> total_force = {}, total_moment = {};
  std::optional<double> angular_velocity = {};  ///< rad/time about `axis`; needs a density
  /// Change of the temperature in the middle of the shell, and difference between top and bottom;
  /// needs a thermal expansion.
  std::optional<double> temperature = {}, temperature_difference = {};
  std::optional<Vec3> axis = {};    ///< direction
  std::optional<Vec3> origin = {};  ///< a point of the axis; empty: [0, 0, 0]
  std::optional<double> level = {};
  std::optional<Vec3> point = {};  ///< the force acts at the nearest point of the surface
  std::string curve = {};
  std::string face = {};         ///< limits a load per area to this face
  std::optional<Box3> box = {};  ///< limits a load per area or length to this box
  std::string load_case = {};    ///< name of the load case (key `case`); empty: "loads"
};

/// A shell and its loads: the keys and defaults of [stress] in docs/stress.md. Use consistent units,
/// for example mm, N, N/mm², t/mm³.
struct StressSettings {
  std::string material = {};  ///< "steel", "stainless steel", "aluminium", …; empty: `young`
  double young = 0, poisson = 0.3, density = 0;  ///< your own material; density 0: none
  double thickness = 0;                          ///< model units, above 0
  double yield_stress = 0;                       ///< 0: none
  std::vector<ShellSupport> supports = {};
  std::vector<ShellLoad> loads = {};
  int modes = 0;     ///< number of natural frequencies
  int buckling = 0;  ///< number of buckling factors of each load case
  /// Relative error of displacements and largest stresses: the elements are refined adaptively until
  /// the estimated errors are below it (refine_shell()); larger errors are failed_checks(). 0: the
  /// elements of the model, as of a session, and a warning for stresses that are uncertain on them.
  double accuracy = 0;
  /// Further keys as TOML text, such as "hinges = [\"lid\"]".
  std::string settings = {};
};

/// The resultant of the reactions of one support.
struct ShellReaction {
  std::string support;                               ///< such as "clamped front"
  Vec3 force = Vec3::Zero(), moment = Vec3::Zero();  ///< on the shell; moment about the origin
};

/// A place at which stresses grow without limit as the elements become smaller, and the distance up
/// to which they are left out of the largest stress.
struct StressSingularity {
  Vec3 at = Vec3::Zero();
  double radius = 0;  ///< model units
};

/// Results of one load case, or of a combination of load cases. The members have the names of
/// report.json.
struct StressCase {
  std::string name;
  bool combination = false;
  Vec3 force = Vec3::Zero();  ///< resultant force of all loads
  double max_displacement = 0;
  double max_displacement_error = 0;  ///< estimated error of `max_displacement`
  Vec3 displacement = Vec3::Zero();   ///< displacement vector at the maximum
  Vec3 displacement_at = Vec3::Zero();
  std::string displacement_face;
  double max_von_mises = 0;
  Vec3 stress_at = Vec3::Zero();         ///< point of the middle surface with the largest stress
  std::string stress_face, stress_side;  ///< side: "top" (where the normal points) or "bottom"
  /// Largest difference between `max_von_mises` and the stresses of the surrounding elements.
  double stress_spread = 0;
  bool near_singularity = false;  ///< whether the maximum is next to a point load or support
  std::vector<StressSingularity> singular_places;  ///< found if StressSettings::accuracy is set
  int stress_ply =
      0;  ///< ply of a laminate with the largest stress, from 1, from the bottom; 0: none
  /// Smallest factors by which the stresses of the plies can grow until they fail, by the name of the
  /// criterion: "Tsai-Hill", "Hoffman"; empty: no material has strengths.
  std::map<std::string, double> reserve_factors;
  double safety_factor = 0;  ///< yield_stress / max_von_mises; 0: no yield stress
  double strain_energy = 0;
  double error_estimate = 0;  ///< estimated relative error in the energy norm
  /// Sum of the forces of loads and supports, relative to the sum of their magnitudes, or the same
  /// for their moments, whichever is larger.
  double equilibrium_residual = 0;
  std::vector<double> buckling_factors;
  std::vector<ShellReaction> reactions;
};

/// Stresses and displacement at a point of the shell.
struct StressPoint {
  Vec3 position = Vec3::Zero(), normal = Vec3::Zero();
  std::string face;
  double distance = 0;  ///< distance from the query point to `position`
  Vec3 displacement = Vec3::Zero();
  double von_mises_top = 0, von_mises_middle = 0, von_mises_bottom = 0;
  /// Membrane forces and bending moments per length, as symmetric tensors in the tangent plane, in
  /// space coordinates. A positive moment causes tension at the top.
  Mat3 forces = Mat3::Zero(), moments = Mat3::Zero();
  /// Stresses (σ1, σ2, τ12) at the bottom and top of each ply, from the bottom, in the directions of its
  /// material; of a shell without plies, at its bottom and top.
  std::vector<Vec3> ply_stresses;
};

/// The result of stress(). Immutable: copies share their data. All functions may be called by
/// several threads at once.
///
/// Functions of a load case take its name; the default is the governing one, which has the largest
/// von Mises stress. They throw InputError, with the nearest name, for an unknown one.
class Stress {
 public:
  explicit Stress(std::shared_ptr<const detail::StressData> data) : data_(std::move(data)) {}

  double max_von_mises() const;     ///< over all load cases
  double max_displacement() const;  ///< over all load cases
  const std::vector<StressCase>& cases() const;
  const StressCase& load_case(const std::string& name = "") const;
  /// Natural frequencies, ascending, 1/time; empty unless requested.
  const std::vector<double>& frequencies() const;

  /// Values at the point of the surface nearest to `p`. Cost: recovery of stresses at the first call
  /// for a load case; then that of Model::nearest().
  StressPoint at(const Vec3& p, const std::string& load_case = "") const;
  /// The larger von Mises stress of top and bottom side at each point of model().facets(); computed
  /// at the first call.
  const std::vector<double>& von_mises(const std::string& load_case = "") const;
  /// The von Mises stress of one side, "top", "middle" or "bottom", at these points. Throws
  /// InputError for another side.
  std::vector<double> von_mises(const std::string& load_case, const std::string& side) const;
  std::vector<double> thickness() const;  ///< of the shell at these points, model units
  /// The displacement (x, y, z of each in turn) at the points of model().facets().
  const std::vector<double>& displacement(const std::string& load_case = "") const;
  /// Mode shapes as displacements (x, y, z of each in turn) at the points of model().facets(). The
  /// largest displacement has length 1. `index`: from 0, as in frequencies() and
  /// StressCase::buckling_factors. Throws InputError for another index.
  std::vector<double> mode_shape(int index) const;
  std::vector<double> buckling_shape(int index, const std::string& load_case = "") const;

  /// Largest displacement, compliance, a smooth measure of the largest stress, and mass, with their
  /// derivatives with respect to the parameters of the model, by the adjoint method. All other
  /// settings, such as the thickness, stay as they are; supports and loads at points follow the
  /// surface as in a new analysis.
  ///
  /// `norm_exponent`: P of the P-norm of the von Mises stress (analysis/models/von_mises_norm.h),
  /// from 2 to 100. Throws InputError for another one, or if a support or a load is limited by a box;
  /// and the exceptions of stress() and Model::gradients(). Cost: one
  /// analysis, Model::gradients(), and two stiffness matrices per parameter.
  StressGradients gradients(double norm_exponent = 8, const std::string& load_case = "",
                            const Progress& progress = {}) const;

  /// Warnings, and failed checks as sentences with the measured value; empty if there are none.
  const std::vector<std::string>& warnings() const;
  const std::vector<std::string>& failed_checks() const;
  /// All results, as the JSON text of the section "stress" of report.json.
  std::string report() const;

  /// The model that was analysed, with smaller elements if StressSettings::accuracy required them.
  Model model() const;
  /// The scene of the model with this [stress]; `batten stress` gives the same results.
  std::string scene() const;

  // For Batten's own front ends.
  const std::shared_ptr<const detail::StressData>& shared_data() const { return data_; }

 private:
  std::shared_ptr<const detail::StressData> data_;
};

/// Result of Session::stress(): maxima over all load cases, and fields of the governing load case,
/// the one with the largest von Mises stress.
struct SessionStress {
  std::string load_case;  ///< name of the governing load case
  double max_von_mises = 0, max_displacement = 0;
  /// The larger von Mises stress of top and bottom side at each point of Session::frame().
  std::vector<float> von_mises = {};
  std::vector<float> displacement = {};  ///< x, y, z of each of these points in turn
};

/// Analyses a model as a linear thin shell (docs/stress.md, docs/theory/shells.md).
///
/// The settings replace the whole [stress] of the model; without settings, the model's own [stress]
/// is used. Writes no files. Cost: one factorization; per load case three solves, two recoveries of
/// stresses and the error estimates.
///
/// Throws InputError ("stress(): supports[1]: found …, expected …"), ConflictError for contradictory
/// supports, NoSolutionError that names an unconstrained motion, CancelledError.
Stress stress(const Model& model, const StressSettings& settings = {},
              const Progress& progress = {});

}  // namespace batten
