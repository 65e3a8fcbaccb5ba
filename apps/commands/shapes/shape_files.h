// Writes a finished shape as the files and numbers that a scene asks for.
#pragma once

#include <vector>

#include "batten/apps/commands/runs/run_support.h"
#include "batten/apps/commands/shapes/solved_shape.h"
#include "batten/io/report/report.h"
#include "batten/core/progress.h"

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


// Writes a finished shape to one file.

/// Measures a shape and writes it to one file, by the file's ending:
///
///     .step .stp      CAD faces, as [output] asks for them
///     .vtp            display facets with normals and curvatures
///     .vtu .inp       quadratic elements; a CalculiX deck, of a scene with [stress]
///     all others      what run_convert() makes of the STEP file: CAD formats, triangles
///
/// No file: it is measured only. The report says what was measured; report.missed has the promises
/// that are broken, those of the file too. Throws InputError for an ending that nothing writes
/// and for a deck without [stress], and what run_scene() throws.
Report export_shape(const Scene& scene, const BuiltModel& made, const SolvedShape& shape,
                    const std::filesystem::path& file, const Progress& progress = {});


// The promises that a result must keep.

/// The promises that the measured numbers break, and numbers that are not finite. The promises are:
///
///   curves    conditions of [[fair]] ≤ 1e-12 of the curve's size
///   lines     deviation of input from fitted curve ≤ tolerance
///   surface   constraint residual ≤ 1e-10 of the region's size, held normals ≤ 1e-6°,
///             normal jump inside ≤ 1e-3°, Jacobian ≥ 0.05 of its median, no singular node;
///             when lines are held: line residual ≤ 1e-10, gap of embedded lines and line
///             deviation ≤ tolerance
///   step      exact: valid, gap and (of HCT surfaces) deviation ≤ 1e-9 of the size plus the step's
///             tolerance, normal jump ≤ 1e-3°
///             one face: valid, deviation ≤ the step's tolerance; when lines are held, gap ≤ that
///             plus `tolerance`
///
/// Each region of a network keeps the promises of `surface` (its lines may also have been moved by
/// the network's tolerance where they were joined), and
///
///   regions   each is skinned; no flaw (SurfaceDefect)
///   joins     a smooth one stays under the join tolerance along all of it (0.05° more under loads
///             and moves), but for ends where the lines leave no tangent plane; one that is asked
///             for as smooth is smooth
///
/// `tolerance` is that of lines, in model units.
std::vector<FailedCheck> failed_checks(const Report& report, double tolerance);

}  // namespace batten
