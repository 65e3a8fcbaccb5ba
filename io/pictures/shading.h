// SPDX-License-Identifier: MPL-2.0
// The common look of pictures: materials lit as in a photo studio, a soft shadow on the floor, and
// ambient occlusion.
#pragma once

#include <vtkSmartPointer.h>
#include <vector>

#include "batten/io/pictures/picture_camera.h"

class vtkActor;
class vtkFloatArray;
class vtkPolyData;
class vtkRenderer;

namespace batten::detail {

/// How strongly a surface reflects the lamps.
enum class Finish {
  Paint,  ///< reflections of two long lamps, as on car paint
  Curve,  ///< faint reflections, for tubes
  Field   ///< weak shading, so that colours can be compared with a colour scale
};

/// Lights an actor with a key light from the upper left, a fill light from the right, a bright
/// ceiling and a darker floor, all fixed to the camera. The actor needs normals.
void apply_finish(vtkActor& actor, Finish finish);

/// Adds the shadow that facets cast on the floor below them when light comes evenly from above.
///
/// The floor is perpendicular to `up_axis`, 0 (x) to 2 (z), at the lowest point. There is no shadow
/// if the camera looks from below, nearly horizontally, or from straight above. Cost: O(facets).
void add_floor_shadow(vtkRenderer& renderer, vtkPolyData& facets, const ViewAxes& axes,
                      int up_axis);

/// Factors from 0 (occluded) to 1 (open), row by row from the bottom; one per kOcclusionStep² pixels.
inline constexpr int kOcclusionStep = 6;
struct OcclusionMap {
  int columns = 0, rows = 0;
  std::vector<float> factors;
  /// Factor at a pixel of the part, interpolated linearly.
  float at(double x, double y) const;
};
/// Horizon-based ambient occlusion [Bavoil2008] of a part of the window in parallel projection.
///
/// `depths`: depth buffer of the window, `window_width` values per row. The part has its lower left
/// corner at (left, bottom); all lengths are in pixels of the depth buffer. `scale`: depth of the
/// whole buffer range in pixels. The factors also contain a loss of light towards the lower right
/// corner. Cost: O(pixels).
OcclusionMap ambient_occlusion(const vtkFloatArray& depths, int window_width, int left, int bottom,
                               int width, int height, double scale);

}  // namespace batten::detail
