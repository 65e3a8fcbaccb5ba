// SPDX-License-Identifier: MPL-2.0
// Manipulator with arrows and rings, to move and rotate a point.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "batten/apps/studio/view/shape_colours.h"
#include "batten/core/eigen.h"

class vtkRenderer;

namespace batten::studio {

struct Layer;

/// Manipulator: three arrows along x, y and z, a ball that moves in the view plane and, if rotation
/// is enabled, three rings. Pixels are those of the renderer, with the origin at the lower left.
class Gizmo {
 public:
  explicit Gizmo(vtkRenderer* renderer);
  ~Gizmo();

  /// Shows the manipulator at a point. `arrow_length` is in model units.
  void show(const Vec3& centre, double arrow_length, bool can_rotate);
  void hide();
  bool shown() const { return shown_; }
  const Vec3& centre() const { return centre_; }
  void set_palette(const Palette& palette);

  /// Starts a drag if the pixel is on one of the parts; otherwise returns false.
  bool press(const Vec2& pixel);
  /// Motion since press(): a translation, or a rotation vector (axis times angle in degrees).
  struct Motion {
    Vec3 shift = Vec3::Zero(), rotation_vector = Vec3::Zero();
  };
  /// Continues the drag and returns the motion so far.
  Motion move(const Vec2& pixel);
  void release();
  bool pressed() const { return part_ >= 0; }
  /// A model point on an arrow (part 0 to 2) or a ring (3 to 5); for tests and tours.
  Vec3 point_on_part(int part) const;

 private:
  std::vector<Vec3> outline(int part) const;
  Vec3 axis() const;
  Vec2 at(const Vec3& p) const;            // position in the window
  Vec3 in_world(const Vec2& pixel) const;  // in the plane through the centre that faces the eye
  Vec3 to_eye() const;
  double angle_of(const Vec2& pixel) const;
  void draw();

  vtkRenderer* renderer_;
  std::array<std::unique_ptr<Layer>, 7> layers_;
  bool shown_ = false, can_rotate_ = false;
  Vec3 centre_ = Vec3::Zero(), start_ = Vec3::Zero();
  double arrow_length_ = 1;
  int part_ = -1;
  Vec2 from_ = Vec2::Zero();
  double angle_ = 0, last_angle_ = 0;
};

}  // namespace batten::studio
