// Writes a finished shape as the files and numbers that a scene asks for.
#pragma once

#include "batten/apps/commands/runs/run_support.h"
#include "batten/apps/commands/shapes/solved_shape.h"
#include "batten/io/report/report.h"

namespace batten {

/// One run of a command: its output folder and its report.
struct RunContext {
  explicit RunContext(const Scene& scene, const std::filesystem::path& folder);
  /// Adds broken promises to the report and writes report.json. Call out.commit() after it.
  void finish(const Progress& progress);

  OutputFolder out;
  Report report;
  Stopwatch watch;
  double tolerance = 0;  ///< tolerance of lines, model units
};

/// Reads and fairs the scene's lines, puts them into the report and makes their model.
BuiltModel model_of(RunContext& run, const Scene& scene, const Progress& progress);

/// Puts the shape into the model, measures it and fills the report: lines, surface, network, scans
/// and reactions.
void measure_into(RunContext& run, BuiltModel& made, const SolvedShape& shape, const Scene& scene,
                  const Progress& progress);

/// Does [compare] and writes the files of [output]: all but report.json, pictures and STEP. When a
/// file cannot hold a region of a network, it is written without it, and report.missed says so.
/// Throws InputError.
void write_files(RunContext& run, const Scene& scene, const BuiltModel& made,
                 const SolvedShape& shape, const Progress& progress);

/// Draws the pictures of [[picture]]. Without a display it draws none, and report.missed says so.
void draw_pictures(RunContext& run, const Scene& scene, const BuiltModel& made,
                   const SolvedShape& shape, const Progress& progress);

/// Writes the STEP file of [output]: the last one, since it takes longest. Regions that turn over
/// are not in it; others as in write_files().
void write_step_file(RunContext& run, const Scene& scene, const BuiltModel& made,
                     const Progress& progress);

/// What to draw of a shape: `look` with its regions, and with the arcs of the network that no
/// region has.
PictureScene shape_picture(const PictureScene& look, const BuiltModel& made,
                           const SolvedShape& shape);

}  // namespace batten
