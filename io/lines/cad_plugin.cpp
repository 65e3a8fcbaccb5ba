// SPDX-License-Identifier: MPL-2.0
// The function table of programs that link OpenCASCADE, and of the module batten_cad.so.
#include "batten/io/lines/cad_plugin.h"

namespace batten {

const CadPlugin& linked_cad_plugin() {
  static const CadPlugin calls{
      &write_step,          &write_step_faces, &step_size_warning, &check_step,
      &measure_continuity,  &read_cad_lines,   &read_cad_surfaces, &read_cad_loops,
      &read_cad_neighbours, &write_cad_curves, &read_cad_contents, &convert_cad,
      &join_cad_files,      &tessellate_cad,   &distance,          &enable_sandboxed_read,
      &set_thread_count};
  return calls;
}

// A program that defines cad_plugin() itself does not link this source, because nothing else in it
// is used there.
const CadPlugin& cad_plugin() { return linked_cad_plugin(); }

}  // namespace batten

/// Entry point of the module. Variables that the program has too, such as the list of temporary
/// files, are those of the program, because its symbols take precedence.
extern "C" const batten::CadPlugin* batten_cad() { return &batten::linked_cad_plugin(); }
