// Implements `batten sculpt`: changes a scene's surface in a session, step by step.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "batten/core/progress.h"
#include "batten/io/report/report.h"

namespace batten {

/// Operations of `batten sculpt`.
struct SculptTask {
  std::vector<std::string> settings;  ///< "name=value"
  std::vector<std::string> sweeps;    ///< "name=from:to:count"
  double time = 0, dt = 0;            ///< duration and time step of a motion; 0: no motion
  /// Maximum number of frames of a motion, besides the first.
  int frames = 60;
  std::string refinement;                ///< "jumps:ROUNDS"; empty: none
  bool stress = false;                   ///< analyse the shell of [stress] at each value of a sweep
  std::filesystem::path record, replay;  ///< log to write, log to read; empty: none
};

/// Solves the scene's shape in a session, then performs the operations of the task in this order:
///
///     replay      applies the operations of a log
///     settings    sets parameters of the session, then solves to equilibrium
///     refinement  bisects triangles at curvature jumps, for the given number of rounds
///     sweeps      solves at each value, starting from the previous shape (and analyses the shell
///                 of [stress] if requested); then resets the parameter
///     motion      dynamic motion from the equilibrium, initially at rest, in steps of dt
///
/// Writes the following files, all or none: those of [output] and [[picture]] with the final shape;
/// per sweep NAME_PARAMETER_000.vtp …, .pvd, .png (contact sheet) and .gif; for a motion the same
/// as NAME_time…, but with one .png per frame; report.json. The log is written last. A value
/// without a solution ends its sweep; the previous results are kept and report.failed_checks tells
/// about it. [[sweep]] is ignored (run_scene() handles it). Throws the exceptions of run_scene().
Report run_sculpt(const Scene& scene, const SculptTask& task, const std::filesystem::path& folder,
                  const Progress& progress = {});

/// A summary of the most important results and the files; each file series takes one line.
std::string sculpt_summary(const Report& report, const std::filesystem::path& folder);

}  // namespace batten
