// SPDX-License-Identifier: MPL-2.0
// Table of the functions that depend on OpenCASCADE. They are either linked into a program, or in a
// plug-in module that the program loads at the first call.
#pragma once

#include "batten/core/parallel.h"
#include "batten/io/cad/cad_convert.h"
#include "batten/io/cad/cad_join.h"
#include "batten/io/cad/continuity_report.h"
#include "batten/io/files/input_file.h"
#include "batten/io/lines/cad_lines.h"
#include "batten/io/lines/cad_neighbours.h"
#include "batten/io/step/step.h"

namespace batten {

/// The functions of the OpenCASCADE plug-in. Members point to the functions of the same names.
struct CadPlugin {
  decltype(&batten::write_step) write_step;
  decltype(&batten::write_step_faces) write_step_faces;
  decltype(&batten::step_size_warning) step_size_warning;
  decltype(&batten::check_step) check_step;
  decltype(&batten::measure_continuity) measure_continuity;
  decltype(&batten::read_cad_lines) read_cad_lines;
  decltype(&batten::read_cad_surfaces) read_cad_surfaces;
  decltype(&batten::read_cad_loops) read_cad_loops;
  decltype(&batten::read_cad_neighbours) read_cad_neighbours;
  decltype(&batten::write_cad_curves) write_cad_curves;
  decltype(&batten::read_cad_contents) read_cad_contents;
  decltype(&batten::convert_cad) convert_cad;
  decltype(&batten::join_cad_files) join_cad_files;
  decltype(&batten::tessellate_cad) tessellate_cad;
  double (*distance)(const std::vector<CadSurface>& faces, const Vec3& p, size_t& first);
  /// Functions that forward settings of the program to the plug-in module, which has its own copies
  /// of global variables.
  decltype(&batten::enable_sandboxed_read) enable_sandboxed_read;
  decltype(&batten::set_thread_count) set_thread_count;
};

/// The table of OpenCASCADE functions that this program uses. A program may define cad_plugin()
/// itself to load the plug-in on demand, as `batten` does. Such a program starts without loading
/// the 16 libraries of OpenCASCADE, which take half of the start-up time.
const CadPlugin& cad_plugin();

/// The table of those OpenCASCADE functions that are linked into this program or module.
const CadPlugin& linked_cad_plugin();

}  // namespace batten
