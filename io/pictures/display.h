// The X server that pictures are drawn with.
#pragma once

namespace batten {

/// Throws InputError when there is no X server that VTK can draw with: VTK itself would end the
/// program. Call it before a long computation that ends in pictures, on the main thread.
void require_display();

}  // namespace batten
