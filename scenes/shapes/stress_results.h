// SPDX-License-Identifier: MPL-2.0
// Stress results of a scene's shape, without files: report, sensitivities to its parameters.
#pragma once

#include <complex>
#include <string>
#include <vector>

#include "batten/analysis/models/shell_results.h"
#include "batten/core/progress.h"
#include "batten/core/solvers/linear_solver_backend.h"
#include "batten/io/report/report.h"
#include "batten/scenes/shapes/solved_shape.h"

namespace batten {

class SpectrumField;  // stress_spectrum.h

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

/// Analyses the shape as the shell of scene.stress: all load cases and combinations with one
/// factorization and, if requested, buckling factors and natural frequencies.
///
/// Adds warnings to `notes`, and a failed check if the reactions do not balance the loads.
/// `factors`: linear solver backend; empty: SparseCholesky. `shape` must have a layout. Throws
/// InputError with the location in the scene, ConflictError, and NoSolutionError that names an
/// unconstrained motion.
StressReport compute_stresses(const Scene& scene, const SolvedShape& shape,
                              const BackendFactory& factors, RunReport& notes,
                              StressVisitor& visitor, const Progress& progress);

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
