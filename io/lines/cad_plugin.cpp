#include "batten/io/lines/cad_plugin.h"

namespace batten {

// Apart from linked_cad_plugin(), so that a program with a cad_plugin() of its own does not link it.
const CadPlugin& cad_plugin() { return linked_cad_plugin(); }

}  // namespace batten
