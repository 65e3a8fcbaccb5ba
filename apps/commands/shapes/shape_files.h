// A finished shape as the files and numbers that a scene asks for.
#pragma once

#include "batten/apps/commands/runs/run_parts.h"
#include "batten/apps/commands/shapes/make_shape.h"
#include "batten/io/report/report.h"

namespace batten {

/// One run of a command: its folder and its report, which appear together in the end.
struct ShapeRun {
  explicit ShapeRun(const Scene& scene, const std::filesystem::path& folder);
  /// Broken promises, and report.json; out.commit() comes last.
  void finish(const Progress& progress);

  OutputFolder out;
  Report report;
  Stopwatch watch;
  double tolerance = 0;  ///< of lines, model units
};

/// The scene's lines, as [[fair]] leaves them, into the report, and the model that they make.
MadeModel model_of(ShapeRun& run, const Scene& scene, const Progress& progress);

/// Puts the shape into the model and measures it: lines, surface, network, scans and reactions of
/// the report.
void measure_into(ShapeRun& run, MadeModel& made, const MadeShape& shape, const Scene& scene,
                  const Progress& progress);

/// [compare] and [output]: everything but report.json and pictures. Of a network, a file that
/// refuses a region is missed, and the others are written. Throws InputError.
void write_files(ShapeRun& run, const Scene& scene, const MadeModel& made, const MadeShape& shape,
                 const Progress& progress);

/// [[picture]]. Without a display they are missed: a result without them is still a result, but not
/// what was asked for.
void draw_pictures(ShapeRun& run, const Scene& scene, const MadeModel& made, const MadeShape& shape,
                   const Progress& progress);

/// A look at a shape.
PictureScene picture_of(const PictureScene& look, const MadeModel& made, const MadeShape& shape);

}  // namespace batten
