// SPDX-License-Identifier: MPL-2.0
#include "batten/scenes/shapes/stress_places.h"

namespace batten {

std::vector<std::string> find_lines(const ModelLayout& layout, const Scene& scene,
                                    const LocatedString& line) {
  std::vector<std::string> all, found;
  for (const ModelLine& l : layout.lines()) {
    all.push_back(l.name);
    if (is_part_of(l.name, line.text)) found.push_back(l.name);
  }
  if (found.empty())
    throw InputError(scene.at(line.location) + "found the curve '" + line.text + "', expected " +
                     expected_one_of(line.text, all));
  return found;
}

int find_region(const ModelLayout& layout, const Scene& scene, const LocatedString& region) {
  std::vector<std::string> names;
  for (const auto& r : layout.regions()) {
    if (r->name() == region.text) return isize(names);
    names.push_back(r->name());
  }
  throw InputError(scene.at(region.location) + "found the face '" + region.text + "', expected " +
                   expected_one_of(region.text, names));
}

ShellLocation place_of(const Scene& scene, const ModelLayout& layout, const Points& shape,
                       const Vec3& point, const SourceLocation& at) {
  const ShellLocation location = nearest_location(layout, shape, point);
  constexpr double far = 0.05;  // relative to the model size
  if (location.distance > far * layout.size())
    throw InputError(scene.at(at) + "found a point at a distance of " +
                     format_number(location.distance) + " " + scene.unit +
                     " from the surface, expected one on the surface");
  return location;
}

ShellPart part_of(const Scene& scene, const ModelLayout& layout, const LocatedString& region,
                  const std::optional<Box3>& box) {
  ShellPart part;
  if (!region.text.empty()) part.regions = {find_region(layout, scene, region)};
  part.box = box;
  return part;
}

}  // namespace batten
