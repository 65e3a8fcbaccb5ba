// SPDX-License-Identifier: MPL-2.0
#include "batten/skinning/surfaces/mirror_images.h"

#include <algorithm>
#include <set>

#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/fairing/curves/primitive_curves.h"

namespace batten {
namespace {

const std::string kMirrored = "mirrored ";

std::vector<Vec3> mirror_samples(const InputCurve& curve) {
  constexpr int samples = 64;
  std::vector<Vec3> points;
  for (int i = 0; i <= samples; ++i)
    points.push_back(curve.evaluate(curve.start() + (curve.end() - curve.start()) * i / samples));
  return points;
}

// Names of the mirror images: "rail.2" becomes "mirrored rail.2".
class MirrorImages {
 public:
  explicit MirrorImages(const std::vector<CharacterLine>& lines) {
    for (const CharacterLine& line : lines) names_.insert(line.name);
  }
  // The name of the mirror image; unchanged for lines in the plane.
  std::string of(const std::string& name) const {
    const size_t dot = name.rfind('.');
    const bool has = names_.count(kMirrored + name) ||
                     (dot != std::string::npos && names_.count(kMirrored + name.substr(0, dot)));
    return has ? kMirrored + name : name;
  }

 private:
  std::set<std::string> names_;
};

}  // namespace

void add_mirror_images(const SymmetryPlane& plane, std::vector<CharacterLine>& lines) {
  const AffineTransform mirror = reflection_in(plane.point, plane.normal);
  const Vec3 normal = plane.normal.normalized();
  const auto height = [&](const Vec3& p) { return normal.dot(p - plane.point); };
  std::vector<std::vector<Vec3>> points;
  Box3 box;
  for (const CharacterLine& line : lines) {
    points.push_back(mirror_samples(*line.curve));
    box.extend(bounding_box(points.back()));
  }
  constexpr double near = 1e-3;  // relative to the size
  const double tolerance = plane.tolerance > 0 ? plane.tolerance : near * box.diagonal().norm();
  const size_t count = lines.size();
  for (size_t i = 0; i < count; ++i) {
    const auto [low, high] =
        std::minmax_element(points[i].begin(), points[i].end(),
                            [&](const Vec3& a, const Vec3& b) { return height(a) < height(b); });
    if (height(*low) < -tolerance && height(*high) > tolerance)
      throw InputError("found the curve '" + lines[i].name +
                       "', which crosses the plane of symmetry from " + format_point(*low) +
                       " to " + format_point(*high) +
                       ", expected curves that lie on one side of the plane or in it");
    if (height(*low) >= -tolerance && height(*high) <= tolerance) continue;
    CharacterLine image = lines[i];
    image.name = kMirrored + image.name;
    image.curve = transformed(lines[i].curve, mirror);
    lines.push_back(std::move(image));
  }
}

std::vector<JoinSpec> with_mirror_images(const std::vector<JoinSpec>& joins,
                                         const std::vector<CharacterLine>& lines) {
  const MirrorImages images(lines);
  std::vector<JoinSpec> all;
  for (const JoinSpec& join : joins)
    if (const std::string image = images.of(join.line); image != join.line)
      all.push_back({image, join.kind, join.where});
  all.insert(all.end(), joins.begin(), joins.end());
  return all;
}

std::vector<RegionSpec> with_mirror_images(const std::vector<RegionSpec>& regions,
                                           const std::vector<CharacterLine>& lines) {
  std::vector<RegionSpec> all = regions;
  const MirrorImages images(lines);
  const auto names_of = [](const RegionSpec& region) {
    std::multiset<std::string> names;
    for (const auto& loop : region.loops) names.insert(loop.begin(), loop.end());
    return names;
  };
  for (const RegionSpec& region : regions) {
    RegionSpec image = region;
    bool whole = false;  // contains lines of both halves
    for (std::string& name : image.inner) name = images.of(name);
    for (auto& loop : image.loops)
      for (std::string& name : loop) {
        whole |= name.starts_with(kMirrored);
        name = images.of(name);
      }
    const bool given = std::any_of(regions.begin(), regions.end(), [&](const RegionSpec& other) {
      return names_of(other) == names_of(image);
    });
    if (whole || given) continue;
    if (!image.name.empty()) image.name = kMirrored + image.name;
    all.push_back(std::move(image));
  }
  return all;
}

}  // namespace batten
