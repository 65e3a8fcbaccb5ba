#include "batten/skinning/domains/size_field.h"

#include <utility>

namespace batten {

SizeField::SizeField(std::shared_ptr<const ParametricMesh> mesh, std::vector<double> lengths)
    : mesh_(std::move(mesh)), locator_(*mesh_), lengths_(std::move(lengths)) {}

double SizeField::at(const Vec2& uv) const {
  const Location where = locator_.locate(uv);
  const auto& corners = mesh_->triangles()[where.triangle];
  double length = 0;
  for (int k = 0; k < 3; ++k) length += where.L[k] * lengths_[corners[k]];
  return length;
}

}  // namespace batten
