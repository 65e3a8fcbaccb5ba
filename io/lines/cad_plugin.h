// Function table of everything that programs use of OpenCASCADE. It is either linked in, or in a
// plug-in module that a program loads at the first call.
#pragma once

#include "batten/core/parallel.h"
#include "batten/io/cad/cad_convert.h"
#include "batten/io/cad/continuity_report.h"
#include "batten/io/files/sandboxed_read.h"
#include "batten/io/lines/cad_face_topology.h"
#include "batten/io/lines/cad_lines.h"
#include "batten/io/step/step.h"

namespace batten {

/// The functions of the plug-in; each member has the name of the function it points to.
struct CadPlugin {
  decltype(&batten::write_step) write_step;
  decltype(&batten::write_step_faces) write_step_faces;
  decltype(&batten::step_size_warning) step_size_warning;
  decltype(&batten::check_step) check_step;
  decltype(&batten::measure_continuity) measure_continuity;
  decltype(&batten::read_cad_lines) read_cad_lines;
  decltype(&batten::read_cad_surfaces) read_cad_surfaces;
  decltype(&batten::read_cad_loops) read_cad_loops;
  decltype(&batten::write_cad_curves) write_cad_curves;
  decltype(&batten::read_cad_contents) read_cad_contents;
  decltype(&batten::convert_cad) convert_cad;
  decltype(&batten::tessellate_cad) tessellate_cad;
  double (*distance)(const std::vector<CadSurface>& faces, const Vec3& p, size_t& first);
  /// Forward settings to a module that has global variables of its own, because the program's
  /// symbols do not take precedence over those of the module.
  decltype(&batten::enable_sandboxed_read) enable_sandboxed_read;
  decltype(&batten::set_thread_count) set_thread_count;
};

/// The function table of this program. A program may define this function itself, as `batten` does.
/// Then it starts without loading OpenCASCADE's 16 libraries, which take half of the start-up time.
const CadPlugin& cad_plugin();

/// The table of the functions linked into this program or module.
const CadPlugin& linked_cad_plugin();

}  // namespace batten
