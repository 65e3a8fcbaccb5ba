// SPDX-License-Identifier: MPL-2.0
// Curves, faces, points and values that the table [stress] of a scene names.
#pragma once

#include <string>
#include <vector>

#include "batten/analysis/models/shell_loads.h"
#include "batten/core/errors.h"
#include "batten/io/scene/scene.h"

namespace batten {

/// Names of the layout's lines that are, or are parts of, a line of the scene. Throws InputError,
/// with the location in the scene, if there are none.
std::vector<std::string> find_lines(const ModelLayout& layout, const Scene& scene,
                                    const LocatedString& line);
/// Layout index of a region of the scene. Throws InputError like find_lines().
int find_region(const ModelLayout& layout, const Scene& scene, const LocatedString& region);
/// The point of the surface nearest to a point. Throws InputError, with the location `at`, if it is
/// farther away than 0.05 of the model size.
ShellLocation place_of(const Scene& scene, const ModelLayout& layout, const Points& shape,
                       const Vec3& point, const SourceLocation& at);
/// A face, limited by a box; the whole surface if `region` is empty.
ShellPart part_of(const Scene& scene, const ModelLayout& layout, const LocatedString& region,
                  const std::optional<Box3>& box);

/// The values of a load at a point; errors of its formulas get its place in the scene.
template <class Value>
auto at_load(const Scene& scene, const SceneStress::Load& load, const Value& value) {
  try {
    return value();
  } catch (const InputError& e) {
    throw InputError(scene.at(load.location) + e.what());
  }
}
inline double value_of(const Scene& scene, const SceneStress::Load& load, const Vec3& x) {
  return at_load(scene, load, [&] { return load.value_at(x); });
}
inline Vec3 vector_of(const Scene& scene, const SceneStress::Load& load, const Vec3& x) {
  return at_load(scene, load, [&] { return load.vector_at(x); });
}

}  // namespace batten
