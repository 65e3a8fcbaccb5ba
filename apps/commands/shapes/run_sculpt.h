// The work of `batten sculpt`: a scene's surface under the hands of a script.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "batten/core/progress.h"
#include "batten/io/report/report.h"

namespace batten {

struct SculptTask {
  std::vector<std::string> settings;  ///< "name=value"
  std::vector<std::string> sweeps;    ///< "name=from:to:count"
  double time = 0, dt = 0;            ///< of a motion; 0: none
  int frames = 60;                    ///< most frames of a motion, besides the first
  std::string refinement;             ///< "jumps:ROUNDS"; "": none
  std::filesystem::path record, replay;
};

/// Settles the scene's shape in a session, then does in this order what the task asks for:
///
///     replay      the operations of a log
///     settings    parameters of the session, then settles
///     refinement  so many rounds of curvature jumps
///     sweeps      settles at each value from the one before; the parameter then goes back
///     motion      from the settled shape, at rest, in steps of dt
///
/// and writes, all of them or none: what [output] and [[picture]] ask for, of the shape in the end;
/// for each sweep NAME_PARAMETER_000.vtp … and .pvd, .png (a contact sheet), .gif; for a motion the
/// same as NAME_time…, with a .png for each frame instead; report.json. A value that has no
/// solution ends its sweep; what was reached is kept, and report.missed says so. [[sweep]] is for
/// run_scene(). The log is written last. Throws as run_scene() does.
Report run_sculpt(const Scene& scene, const SculptTask& task, const std::filesystem::path& folder,
                  const Progress& progress = {});

/// What a newcomer wants to know; frames of a series stand in one line.
std::string sculpt_summary(const Report& report, const std::filesystem::path& folder);

}  // namespace batten
