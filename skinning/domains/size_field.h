// How long the edges of elements may be at each place of a domain.
#pragma once

#include <memory>
#include <vector>

#include "batten/fem/triangle_locator.h"

namespace batten {

/// Longest edges of elements over a domain, in its units: linear between the vertices of a background
/// mesh, and outside of it as at its nearest point.
class SizeField {
 public:
  /// One length, > 0, for each vertex of the background mesh.
  SizeField(std::shared_ptr<const ParametricMesh> mesh, std::vector<double> lengths);

  double at(const Vec2& uv) const;
  double at_vertex(int vertex) const { return lengths_[vertex]; }

 private:
  std::shared_ptr<const ParametricMesh> mesh_;
  TriangleLocator locator_;
  std::vector<double> lengths_;
};

}  // namespace batten
