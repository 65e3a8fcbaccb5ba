// Writes a finished shape to one file.
#pragma once

#include "batten/apps/commands/shapes/solved_shape.h"
#include "batten/core/progress.h"
#include "batten/io/report/report.h"

namespace batten {

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

}  // namespace batten
