// CAD files as a model is fitted to them. Internal.
#pragma once

#include "batten/io/cad/cad_file.h"

namespace batten {

/// Faces of which each has edges of its own, as those of IGES files, share them where they lie within 1e-5 of the
/// size of each other. Then faces are divided along the curves where their own surface is only continuous (knots
/// as multiple as the degree): there it may turn as sharply as at an edge, and a line is needed. Parts of an edge
/// keep its label. Other faces and edges stay as they are.
void heal_shape(CadFile& cad);

}  // namespace batten
