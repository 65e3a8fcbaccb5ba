// Conversions between model coordinates and pixels of the window.
#pragma once

#include <vtkRenderer.h>

#include <algorithm>
#include <utility>

#include "batten/core/eigen.h"

namespace batten::studio {

/// Position of a model point in the renderer's pixels (origin at the lower left), and its depth.
inline Vec3 to_display(vtkRenderer& renderer, const Vec3& p) {
  renderer.SetWorldPoint(p.x(), p.y(), p.z(), 1);
  renderer.WorldToDisplay();
  Vec3 window;
  renderer.GetDisplayPoint(window.data());
  return window;
}
/// The same without the depth.
inline Vec2 to_screen(vtkRenderer& renderer, const Vec3& p) {
  return to_display(renderer, p).head<2>();
}
/// Inverse of to_display(): the model point at a pixel and depth.
inline Vec3 to_world(vtkRenderer& renderer, const Vec3& window) {
  double world[4];
  renderer.SetDisplayPoint(window.data());
  renderer.DisplayToWorld();
  renderer.GetWorldPoint(world);
  return Vec3(world[0], world[1], world[2]) / world[3];
}

/// Distance of a point from a segment, and the parameter of the closest point on it, 0 to 1.
inline std::pair<double, double> distance_to_segment(const Vec2& p, const Vec2& a, const Vec2& b) {
  const Vec2 along = b - a;
  const double length = along.squaredNorm();
  const double parameter = length > 0 ? std::clamp((p - a).dot(along) / length, 0.0, 1.0) : 0;
  return {(p - a - parameter * along).norm(), parameter};
}

}  // namespace batten::studio
