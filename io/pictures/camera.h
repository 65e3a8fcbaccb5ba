// The camera of a picture: its direction, and the scale at which the model fits. Internal.
#pragma once

#include <vector>

#include "batten/core/eigen.h"

namespace batten::detail {

/// The camera's axes, orthonormal: to the right, upwards, and towards the camera.
struct ViewAxes {
  Vec3 right, up, towards;
  /// Axes of a camera at this azimuth and elevation, in degrees as in PictureScene. `up`: the axis
  /// that points upwards, 0 (x) to 2 (z); the next one, cyclically, then stands for x.
  ViewAxes(double azimuth, double elevation, int up_axis = 2);
  /// Axes of a camera in this direction from the model. z points upwards in the picture; y does
  /// where the direction is less than 45 degrees away from +z or -z.
  explicit ViewAxes(const Vec3& towards_camera);
};
/// Axes of a camera that looks at right angles onto the plane that fits the points best: from above
/// (+z); from the front (-y) where that plane is steeper than 45 degrees; from the right (+x) where
/// it faces sideways. O(points).
ViewAxes best_view(const std::vector<Vec3>& points);

/// A part of the window in pixels, from its lower left corner.
struct Viewport {
  double width, height;  // size of the viewport
  double top, bottom;    // heights of the strips that are kept free for text
  double unit;           // scale of text and lines; 1 at 1600 × 1000
};

/// The point in the middle of a picture, and its scale.
struct Fit {
  Vec3 focus;
  double pixel;  // length of a pixel in the model
};
/// The focus and scale at which all points are in the viewport when `zoom` is 1; a zoom of 2 draws
/// everything twice as large. O(points).
Fit fit(const std::vector<Vec3>& points, const ViewAxes& axes, const Viewport& viewport,
        double zoom);

}  // namespace batten::detail
