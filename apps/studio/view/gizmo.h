// Arrows and rings at a place, by which a hand moves and turns it.
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

/// Three arrows along x, y and z, a ball for the plane that faces the eye and, where it turns, three
/// rings. Points of the window are the renderer's: pixels from the lower left corner.
class Gizmo {
 public:
  explicit Gizmo(vtkRenderer* renderer);
  ~Gizmo();

  /// Shows it at a place; `arrow_length` is the length of its arrows.
  void show(const Vec3& centre, double arrow_length, bool can_rotate);
  void hide();
  bool shown() const { return shown_; }
  const Vec3& centre() const { return centre_; }
  void set_palette(const Palette& palette);

  /// Begins to move where the hand is on one of its parts; false where it is on none.
  bool press(const Vec2& pixel);
  /// How far the hand has moved it since it was pressed: a shift, or a turn as a vector along its axis,
  /// as long as its angle in degrees.
  struct Motion {
    Vec3 shift = Vec3::Zero(), rotation_vector = Vec3::Zero();
  };
  Motion move(const Vec2& pixel);
  void release();
  bool pressed() const { return part_ >= 0; }
  /// A place of the window on an arrow (0 to 2) or a ring (3 to 5): for tests and tours.
  Vec3 point_on_part(int part) const;

 private:
  std::vector<Vec3> outline(int part) const;
  Vec3 axis() const;
  Vec2 at(const Vec3& p) const;            // in the window
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
