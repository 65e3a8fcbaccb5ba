// SPDX-License-Identifier: MPL-2.0
// Measures a solved shape and writes its files.
#pragma once

#include <vector>

#include "batten/core/progress.h"
#include "batten/io/report/report.h"
#include "batten/scenes/runs/run_support.h"
#include "batten/scenes/shapes/solved_shape.h"

namespace batten {

/// State of one run of a command: output folder, report and timer.
struct RunContext {
  explicit RunContext(const Scene& scene, const std::filesystem::path& folder);
  /// Checks the names of the output files, see OutputFolder::require_replaceable().
  void require_replaceable(const Scene& scene) const;
  /// Adds the failed checks to the report and writes report.json. Call out.commit() afterwards.
  void finish(const Progress& progress);

  OutputFolder out;
  Report report;
  Stopwatch watch;
  double tolerance = 0;  ///< tolerance of lines, model units
};

/// Reads and fairs the scene's lines, adds them to the report, and builds the model.
BuiltModel model_of(RunContext& run, const Scene& scene, const Progress& progress);

/// Stores the shape in the model, measures it and fills the report: lines, surface, network, scans,
/// reactions.
void measure_into(RunContext& run, BuiltModel& made, const SolvedShape& shape, const Scene& scene,
                  const Progress& progress);

/// Evaluates [compare] and writes the files of [output], except report.json, pictures and STEP.
/// Network regions that a format cannot represent are omitted and reported in report.failed_checks.
/// Throws InputError.
void write_files(RunContext& run, const Scene& scene, const BuiltModel& made,
                 const SolvedShape& shape, const Progress& progress);

/// Draws the pictures of [[picture]]. Without a display, it draws none and adds a failed check.
void draw_pictures(RunContext& run, const Scene& scene, const BuiltModel& made,
                   const SolvedShape& shape, const Progress& progress);

/// Writes the STEP file of [output], last because it takes longest. Inverted regions are omitted;
/// for others see write_files().
void write_step_file(RunContext& run, const Scene& scene, const BuiltModel& made,
                     const Progress& progress);

/// The picture of a shape: `look` with its regions, and with the network edges that belong to no
/// region.
PictureScene shape_picture(const PictureScene& look, const BuiltModel& made,
                           const SolvedShape& shape);

// Export of a solved shape to a single file.

/// Measures a shape and writes it to one file; the extension selects the format:
///
///     .step .stp      CAD faces, with the options of [output]
///     .vtp            facets with normals and curvatures, for display
///     .vtu .inp       quadratic elements; a CalculiX deck (requires [stress])
///     all others      converted from STEP by run_convert(): CAD formats, triangle meshes
///
/// If `file` is empty, the shape is only measured. The report contains the measurements, and failed
/// checks of the shape and the file. Throws InputError for an unsupported extension or a deck
/// without [stress], and the exceptions of run_scene().
Report export_shape(const Scene& scene, const BuiltModel& made, const SolvedShape& shape,
                    const std::filesystem::path& file, const Progress& progress = {});

}  // namespace batten
