#include "batten/io/lines/cad_plugin.h"

namespace batten {

const CadPlugin& linked_cad_plugin() {
  static const CadPlugin calls{&write_step,        &write_step_faces,      &step_size_warning,
                               &check_step,        &measure_continuity,    &read_cad_lines,
                               &read_cad_surfaces, &read_cad_loops,        &write_cad_curves,
                               &read_cad_contents, &convert_cad,           &tessellate_cad,
                               &distance,          &enable_sandboxed_read, &set_thread_count};
  return calls;
}

}  // namespace batten
