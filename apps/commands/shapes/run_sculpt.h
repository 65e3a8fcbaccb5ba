// Does the work of `batten sculpt`: changes a scene's surface in a session, step by step.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "batten/core/progress.h"
#include "batten/io/report/report.h"

namespace batten {

/// What to do in a session.
struct SculptTask {
  std::vector<std::string> settings;     ///< "name=value"
  std::vector<std::string> sweeps;       ///< "name=from:to:count"
  double time = 0, dt = 0;               ///< duration and time step of a motion; 0: no motion
  int frames = 60;                       ///< most frames of a motion, besides the first
  std::string refinement;                ///< "jumps:ROUNDS"; "": none
  bool stress = false;                   ///< of the shell of [stress], at each value of a sweep
  std::filesystem::path record, replay;  ///< log to write, log to read; "": none
};

/// Settles the scene's shape in a session, then does what the task asks for, in this order:
///
///     replay      applies the operations of a log
///     settings    sets parameters of the session, then settles
///     refinement  halves triangles at jumps of curvature, in as many rounds as asked for
///     sweeps      settles at each value, from the shape before (and analyses it as the shell of
///                 [stress], where asked for); then sets the parameter back
///     motion      moves from the settled shape, at rest, in steps of dt
///
/// It writes these files, all of them or none: those of [output] and [[picture]], with the shape in
/// the end; for each sweep NAME_PARAMETER_000.vtp … and .pvd, .png (a contact sheet), .gif; for a
/// motion the same as NAME_time…, but with a .png for each frame; report.json. The log is written
/// last. A value without a solution ends its sweep; what was reached is kept, and report.missed
/// says so. [[sweep]] is not used (run_scene() does it). Throws as run_scene() does.
Report run_sculpt(const Scene& scene, const SculptTask& task, const std::filesystem::path& folder,
                  const Progress& progress = {});

/// The most important results and the files, with the files of a series in one line.
std::string sculpt_summary(const Report& report, const std::filesystem::path& folder);

}  // namespace batten
