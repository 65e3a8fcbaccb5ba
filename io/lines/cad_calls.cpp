#include "batten/io/lines/cad_calls.h"

namespace batten {

// Apart from linked_cad(), so that a program with a cad_calls() of its own does not link it.
const CadCalls& cad_calls() { return linked_cad(); }

}  // namespace batten
