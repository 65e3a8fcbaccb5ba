// From where a picture looks at a model, and how large that is then. Internal.
#pragma once

#include <vector>

#include "batten/core/eigen.h"

namespace batten::canvas {

/// Orthonormal: right, up, and towards the camera.
struct ViewAxes {
  Vec3 right, up, towards;
  /// Degrees, as PictureScene has them.
  ViewAxes(double azimuth, double elevation);
  /// Against this direction; z upwards, or y where that looks down on the plane z = 0 (by less than
  /// 45 degrees from above or below).
  explicit ViewAxes(const Vec3& towards_camera);
};
/// Onto the plane that fits the points best, from the side of z, y or x that it faces.
ViewAxes best_view(const std::vector<Vec3>& points);

/// A part of the window in pixels, from its lower left corner.
struct Viewport {
  double width, height;  // of the viewport
  double top, bottom;    // kept free for text
  double unit;           // 1 at 1600 × 1000: sizes of text and lines go with it
};

struct Fit {
  Vec3 focus;
  double pixel;  // length of a pixel in the model
};
/// So that all points are in the viewport, at zoom 1.
Fit fit(const std::vector<Vec3>& points, const ViewAxes& axes, const Viewport& viewport,
        double zoom);

}  // namespace batten::canvas
