// A finished shape as the files and numbers that a scene asks for.
#pragma once

#include "batten/apps/commands/make_shape.h"
#include "batten/apps/commands/output_folder.h"
#include "batten/apps/commands/run_parts.h"
#include "batten/io/report.h"
#include "batten/io/vtk_files.h"

namespace batten {

/// Lines, surface, springs and reactions of the report, measured on the shape.
void measure_into(Report& report, const MadeShape& made);

/// The distance of regions from the faces of the file of [compare]. Throws InputError.
void compare_into(Report& report, const Scene& scene,
                  const std::vector<const SkinnedRegion*>& regions, const Progress& progress);

/// [compare] and [output]: everything but report.json and pictures. Throws InputError.
void write_files(Report& report, const Scene& scene, const SkinnedRegion& region,
                 const VtkOptions& vtk, const OutputFolder& out, Stopwatch& watch,
                 const Progress& progress);

/// A look at one region.
PictureScene picture_of(const PictureScene& look, const SkinnedRegion& region);

}  // namespace batten
