#include "batten/fem/surface_evaluator.h"

#include "batten/elements/bernstein_cubics.h"
#include "batten/elements/c1_triangle.h"

namespace batten {

SurfaceEvaluator::SurfaceEvaluator(Surface surface)
    : surface_(std::move(surface)), locator_(surface_.mesh()) {
  if (surface_.kind() != TriangleElement::HCT) return;
  cubics_.reserve(3 * static_cast<size_t>(surface_.mesh().triangle_count()));
  for (int t = 0; t < surface_.mesh().triangle_count(); ++t) {
    const C1Triangle element(surface_.kind(), surface_.mesh().shape(t));
    for (int sub = 0; sub < 3; ++sub)
      cubics_.emplace_back(element.bezier(sub, surface_.triangle_dofs(t)).transpose());
  }
}

Vec3 SurfaceEvaluator::position(const Location& where) const {
  if (cubics_.empty()) return surface_.position(where);
  const HctSubtriangle at(where.L);
  return cubics_[3 * static_cast<size_t>(where.triangle) + at.sub].lazyProduct(
      bernstein_cubics(at.local));
}

}  // namespace batten
