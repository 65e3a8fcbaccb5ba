// SPDX-License-Identifier: MPL-2.0
#include "batten/analysis/models/parent_triangles.h"

#include <algorithm>

#include "batten/core/containers.h"

namespace batten {

ParentTriangles::ParentTriangles(const ModelLayout& before) : before_(before) {
  for (int r = 0; r < before.region_count(); ++r)
    locators_.push_back(std::make_unique<const TriangleLocator>(*before.region(r).mesh()));
}

int ParentTriangles::of(const ModelLayout& refined, const Location& where) const {
  const int r = refined.region_of(where.triangle);
  const Vec2 uv =
      refined.region(r).mesh()->shape(where.triangle - refined.first_triangle(r)).point(where.L);
  return before_.first_triangle(r) + locators_[static_cast<size_t>(r)]->locate(uv).triangle;
}

std::vector<int> ParentTriangles::of_all(const ModelLayout& refined) const {
  std::vector<int> parents(static_cast<size_t>(refined.mesh()->triangle_count()));
  for (int t = 0; t < isize(parents); ++t)
    parents[static_cast<size_t>(t)] = of(refined, {t, Vec3::Constant(1.0 / 3)});
  return parents;
}

ModelLayout bisected(const ModelLayout& layout, const std::vector<int>& levels) {
  const ParentTriangles parents(layout);
  const int most = levels.empty() ? 0 : *std::max_element(levels.begin(), levels.end());
  ModelLayout finer = layout;
  for (int level = 1; level <= most; ++level) {
    std::vector<char> marks;
    for (const int parent : parents.of_all(finer))
      marks.push_back(levels[static_cast<size_t>(parent)] >= level);
    finer.refine(marks);
  }
  return finer;
}

}  // namespace batten
