// Creases inside of the faces of CAD files. Internal.
#pragma once

#include "batten/io/cad/cad_file.h"

namespace batten {

/// Divides faces along the curves where their own surface is only continuous (knots as multiple as the
/// degree): there it may turn as sharply as at an edge, and a line is needed. Parts of an edge keep its label. Other
/// faces and edges stay as they are.
void divide_at_creases(CadFile& cad);

}  // namespace batten
