// SPDX-License-Identifier: MPL-2.0
// Triangles of a mesh that contain those of its bisections.
#pragma once

#include <memory>
#include <vector>

#include "batten/fem/triangle_locator.h"
#include "batten/skinning/model/model_layout.h"

namespace batten {

/// Relates the triangles of a model that was refined by ModelLayout::refine() to those of the mesh
/// before. Keeps a reference to the layout before.
class ParentTriangles {
 public:
  explicit ParentTriangles(const ModelLayout& before);

  /// Triangle of the mesh before that contains a location of the refined model.
  int of(const ModelLayout& refined, const Location& where) const;
  /// The same for each triangle of the refined model. Cost: about a microsecond per triangle.
  std::vector<int> of_all(const ModelLayout& refined) const;

 private:
  const ModelLayout& before_;
  std::vector<std::unique_ptr<const TriangleLocator>> locators_;  // of each face
};

/// Bisects each triangle `levels[triangle]` times, its halves included, and others as needed for a
/// conforming mesh.
ModelLayout bisected(const ModelLayout& layout, const std::vector<int>& levels);

}  // namespace batten
