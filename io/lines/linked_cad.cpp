#include "batten/io/lines/cad_calls.h"

namespace batten {

const CadCalls& linked_cad() {
  static const CadCalls calls{&write_step,        &write_step_faces,   &step_size_warning,
                              &check_step,        &measure_continuity, &read_cad_lines,
                              &read_cad_surfaces, &read_cad_loops,     &write_cad_curves,
                              &read_cad_contents, &convert_cad,        &facets_of_cad,
                              &distance,          &read_in_child,      &set_thread_count};
  return calls;
}

}  // namespace batten
