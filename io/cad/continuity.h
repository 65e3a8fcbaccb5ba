// How faces of a CAD file meet along their edges: G0, G1, G2.
#pragma once

#include <filesystem>
#include <string>

#include "batten/io/cad/continuity_report.h"

namespace batten {

/// Reads a STEP, IGES or BREP file and measures it. At a point of an edge each face is taken at its
/// nearest point (Newton's method on the surface); curvature is II/I in the direction across the
/// edge. Throws InputError as read_cad_lines() does, on options out of range, and for a file
/// without faces. About 0.1 ms an edge.
ContinuityReport measure_continuity(const std::filesystem::path& file, double model_unit_in_metres,
                                    const ContinuityOptions& options = {});

/// The report in a few lines of text, with the worst edges.
std::string continuity_text(const ContinuityReport& report, const ContinuityOptions& options,
                            const std::string& unit);

}  // namespace batten
