// SPDX-License-Identifier: MPL-2.0
#include "batten/apps/studio/view/gizmo.h"

#include <vtkCamera.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "batten/apps/studio/view/rendering.h"

namespace batten::studio {
namespace {

constexpr int kBall = 6;
constexpr int kRingPieces = 64;
constexpr double kBallSize = 14;
constexpr double kNear = 9;         // pixels
constexpr double kShortArrow = 14;  // pixels: a shorter arrow points at the viewer
constexpr double kRing = 0.72;      // radius, relative to the arrow length
// Cosine to the view direction below which a ring looks like a line.
constexpr double kFlatRing = 0.3;
constexpr double kDegrees = 180 / std::numbers::pi;

}  // namespace

Gizmo::Gizmo(vtkRenderer* renderer) : renderer_(renderer) {
  for (int part = 0; part < static_cast<int>(layers_.size()); ++part)
    layers_[static_cast<size_t>(part)] =
        std::make_unique<Layer>(renderer, kInFront, part < 3 ? 4 : 2.5);
  hide();
}

Gizmo::~Gizmo() = default;

void Gizmo::set_palette(const Palette& palette) {
  const Rgb axes[] = {{0.86, 0.22, 0.20}, {0.20, 0.62, 0.24}, {0.16, 0.40, 0.86}};
  for (size_t part = 0; part < layers_.size(); ++part)
    layers_[part]->set_colour(part < 6 ? axes[part % 3] : palette.selected);
}

void Gizmo::show(const Vec3& centre, double arrow_length, bool can_rotate) {
  centre_ = centre;
  arrow_length_ = arrow_length;
  can_rotate_ = can_rotate;
  shown_ = true;
  draw();
}

void Gizmo::hide() {
  shown_ = false;
  part_ = -1;
  draw();
}

void Gizmo::draw() {
  for (int part = 0; part < static_cast<int>(layers_.size()); ++part) {
    Layer& layer = *layers_[static_cast<size_t>(part)];
    const bool ring = part >= 3 && part < kBall;
    layer.actor->SetVisibility(shown_ && (can_rotate_ || !ring));
    layer.actor->PickableOff();
    if (part == kBall)
      layer.set_dots({centre_}, false, kBallSize);
    else if (shown_)
      layer.set_polylines({outline(part)});
  }
}

std::vector<Vec3> Gizmo::outline(int part) const {
  const Vec3 along = Vec3::Unit(part % 3);
  if (part < 3) {
    const Vec3 tip = centre_ + arrow_length_ * along;
    const Vec3 side = 0.06 * arrow_length_ * Vec3::Unit((part + 1) % 3),
               back = 0.14 * arrow_length_ * along;
    return {centre_, tip, tip - back + side, tip - back - side, tip};
  }
  std::vector<Vec3> ring;
  for (int i = 0; i <= kRingPieces; ++i) {
    const double t = 2 * std::numbers::pi * i / kRingPieces;
    ring.push_back(centre_ + kRing * arrow_length_ *
                                 (std::cos(t) * Vec3::Unit((part + 1) % 3) +
                                  std::sin(t) * Vec3::Unit((part + 2) % 3)));
  }
  return ring;
}

Vec3 Gizmo::point_on_part(int part) const {
  const std::vector<Vec3> line = outline(part);
  return part < 3 ? Vec3(0.5 * (line[0] + line[1])) : line[kRingPieces / 8];
}

Vec2 Gizmo::at(const Vec3& p) const { return to_screen(*renderer_, p); }

Vec3 Gizmo::in_world(const Vec2& pixel) const {
  const double depth = to_display(*renderer_, start_).z();
  return to_world(*renderer_, {pixel.x(), pixel.y(), depth});
}

Vec3 Gizmo::to_eye() const {
  vtkCamera* camera = renderer_->GetActiveCamera();
  return -Vec3::Map(camera->GetDirectionOfProjection());
}

Vec3 Gizmo::axis() const { return Vec3::Unit(part_ % 3); }

bool Gizmo::press(const Vec2& pixel) {
  part_ = -1;
  if (!shown_) return false;
  double least = kNear;
  if ((at(centre_) - pixel).norm() < kNear) {
    part_ = kBall;
    least = 0;
  }
  for (int part = 0; part < kBall; ++part) {
    if (part >= 3 && !can_rotate_) break;
    const std::vector<Vec3> line = outline(part);
    if (part < 3 && (at(line[1]) - at(line[0])).norm() < kShortArrow) continue;
    for (size_t i = 0; i + 1 < line.size(); ++i) {
      const double d = distance_to_segment(pixel, at(line[i]), at(line[i + 1])).first;
      if (d >= least) continue;
      least = d;
      part_ = part;
    }
  }
  start_ = centre_;
  from_ = pixel;
  angle_ = 0;
  last_angle_ = part_ >= 3 && part_ < kBall ? angle_of(pixel) : 0;
  return part_ >= 0;
}

// Angle of a drag on a ring, degrees. A ring that is seen edge-on rotates by the distance along it.
double Gizmo::angle_of(const Vec2& pixel) const {
  const double facing = axis().dot(to_eye());
  const Vec2 arm = pixel - at(start_);
  if (std::abs(facing) > kFlatRing)
    return std::atan2(arm.y(), arm.x()) * kDegrees * (facing > 0 ? 1 : -1);
  const Vec3 tangent = axis().cross(to_eye()).normalized();
  const Vec2 along = at(start_ + kRing * arrow_length_ * tangent) - at(start_);
  return (pixel - at(start_)).dot(along) / along.squaredNorm() * kDegrees;
}

Gizmo::Motion Gizmo::move(const Vec2& pixel) {
  Motion motion;
  if (part_ == kBall) {
    motion.shift = in_world(pixel) - in_world(from_);
  } else if (part_ < 3) {
    const Vec2 along = (at(start_ + arrow_length_ * axis()) - at(start_)) / arrow_length_;
    motion.shift = (pixel - from_).dot(along) / along.squaredNorm() * axis();
  } else {
    const double now = angle_of(pixel);
    angle_ += std::remainder(now - last_angle_, 360.0);
    last_angle_ = now;
    motion.rotation_vector = angle_ * axis();
  }
  centre_ = start_ + motion.shift;
  draw();
  return motion;
}

void Gizmo::release() { part_ = -1; }

}  // namespace batten::studio
