// SPDX-License-Identifier: MPL-2.0
// Stress results of a scene's shape, without files: report, sensitivities to its parameters.
#pragma once

#include <complex>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "batten/analysis/models/shell_refinement.h"
#include "batten/analysis/models/shell_results.h"
#include "batten/core/progress.h"
#include "batten/core/solvers/linear_solver_backend.h"
#include "batten/io/report/report.h"
#include "batten/scenes/shapes/solved_shape.h"

namespace batten {

class SpectrumField;  // stress_spectrum.h

/// Goal of a mesh refinement.
struct StressAccuracy {
  /// Largest accepted relative error of displacements and of the largest stresses; 0: no refinement.
  double value = kDefault;
  /// True: an error above `value` is a failed check, and the number of unknowns is not limited.
  /// False: it is a warning, and the meshes after the first one have together at most
  /// max(100,000, 3 times those of the first) unknowns.
  bool required = false;

  static constexpr double kDefault = 0.02;
};
/// The goal of an argument: nullopt is the default one. Throws InputError for a number that is
/// negative or not finite.
StressAccuracy stress_accuracy(const std::optional<double>& argument);

/// A solved shape on smaller elements of the same surface.
struct RefinedShape {
  SolvedShape shape;
  std::vector<StressReport::Mesh> meshes = {};  ///< results on each mesh; empty: not refined
  bool converged = true;
  /// RefinedShell::shell, or null.
  std::shared_ptr<const ShellModel> shell = {};
  double error_ratio = 1;                                        ///< RefinedShell::error_ratio
  std::vector<std::vector<SingularPlace>> singular_places = {};  ///< of each load case
};
/// Refines the elements of a shape by refine_shell(). A shell whose free motions are not prevented
/// is not refined. Throws the exceptions of refine_shell().
RefinedShape refine_adaptively(const Scene& scene, const SolvedShape& shape,
                               const StressAccuracy& accuracy, const BackendFactory& factors,
                               const Progress& progress);

/// Receives the results of compute_stresses() one by one, for example to write them to files. The
/// arguments are valid during the call only.
class StressVisitor {
 public:
  virtual ~StressVisitor() = default;
  /// Called first, after the factorization.
  virtual void visit_shell(const ShellModel&) {}
  virtual void visit_case(const StressReport::Case&, const ShellCaseResult&, const ShellStresses&) {
  }
  /// Called after visit_case() of the same case if buckling is requested. The shapes (displacement
  /// dofs, n×3) belong to Case::buckling.
  virtual void visit_buckling(const StressReport::Case&, const std::vector<Points>&) {}
  /// Called after visit_case() if a steady vibration is requested. `points`: names, as in
  /// Case::vibrations; `amplitudes`: of each frequency and point.
  virtual void visit_harmonic(const StressReport::Case&, const std::vector<double>& /*frequencies*/,
                              const std::vector<std::string>& /*points*/,
                              const std::vector<std::vector<Eigen::Vector3cd>>& /*amplitudes*/) {}
  /// Called if the response to a spectrum is requested.
  virtual void visit_spectrum(const StressReport::Spectrum&, const SpectrumField&) {}
  /// Called last if modes are requested. `shapes`: displacement dofs, n×3.
  virtual void visit_modes(const std::vector<double>& /*frequencies*/,
                           const std::vector<Points>& /*shapes*/) {}
};

/// Analyses a shape as the shell of scene.stress: all load cases and combinations with one
/// factorization and, if requested, buckling factors and natural frequencies.
///
/// Adds warnings to `notes`, and failed checks if the reactions do not balance the loads or if the
/// `accuracy` of the refinement was not reached. `factors`: linear solver backend; empty:
/// SparseCholesky. `refined.shape` must have a layout. Throws
/// InputError with the location in the scene, ConflictError, and NoSolutionError that names an
/// unconstrained motion.
StressReport compute_stresses(const Scene& scene, const RefinedShape& refined,
                              const StressAccuracy& accuracy, const BackendFactory& factors,
                              RunReport& notes, StressVisitor& visitor, const Progress& progress);

// Sensitivities of displacements to the parameters of a scene.

/// Computes derivatives with respect to each parameter that changes the shape, for every load case
/// of `report`. They are those of the largest displacement (at its location, in its direction) and
/// of the compliance (work of the loads).
///
/// Parameters that do not change the shape are skipped. Throws InputError if a support or a load is
/// limited by a box. Cost: that of ShellSensitivities and of
/// shape_derivatives().
std::vector<StressReport::Sensitivity> compute_sensitivities(const StressReport& report,
                                                             const Scene& scene,
                                                             const BuiltModel& made,
                                                             const SolvedShape& shape,
                                                             const Progress& progress);

}  // namespace batten
