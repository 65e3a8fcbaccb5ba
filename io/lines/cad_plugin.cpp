#include "batten/io/lines/cad_plugin.h"

namespace batten {

// In its own file, so that a program that defines cad_plugin() itself does not link this one.
const CadPlugin& cad_plugin() { return linked_cad_plugin(); }

}  // namespace batten
