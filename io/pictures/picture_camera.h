// SPDX-License-Identifier: MPL-2.0
// The camera of a picture: its direction, and the scale at which the model fits.
#pragma once

#include <vector>

#include "batten/core/eigen.h"

namespace batten::detail {

/// Camera axes, orthonormal: to the right, upwards, and towards the camera.
struct ViewAxes {
  Vec3 right, up, towards;
  /// Axes of a camera at this azimuth and elevation, in degrees as in PictureScene. `up_axis` is
  /// the axis that points upwards, 0 (x) to 2 (z); the cyclically next axis takes the part of x.
  ViewAxes(double azimuth, double elevation, int up_axis = 2);
  /// Axes of a camera that looks from this direction. z points upwards in the picture; if the
  /// direction is less than 45 degrees from +z or −z, y does.
  explicit ViewAxes(const Vec3& towards_camera);
};
/// Axes of a camera perpendicular to the best-fit plane of the points. It looks from above (+z),
/// from the front (−y) if the plane is steeper than 45 degrees, or from the right (+x) if it faces
/// sideways. Cost: O(points).
ViewAxes best_view(const std::vector<Vec3>& points);

/// A rectangular part of the window, in pixels, with the origin at its lower left corner.
struct Viewport {
  double width, height;  // size of the viewport
  double top, bottom;    // heights of the strips reserved for text
  double unit;           // scale of line widths; 1 at 1600 × 1000
};

/// Centre and scale of a picture.
struct Fit {
  Vec3 focus;
  double pixel;  // length of a pixel, in model units
};
/// Computes the centre and scale that fit all points into the viewport at `zoom` = 1. A zoom of 2
/// draws everything twice as large. Cost: O(points).
Fit fit(const std::vector<Vec3>& points, const ViewAxes& axes, const Viewport& viewport,
        double zoom);

}  // namespace batten::detail
