#include "batten/apps/commands/lines/mirror_lines.h"

#include <algorithm>
#include <set>

#include "batten/core/box.h"
#include "batten/core/errors.h"
#include "batten/core/format.h"
#include "batten/fairing/primitive_curves.h"

namespace batten {
namespace {

const std::string kMirrored = "mirrored ";

std::vector<Vec3> sampled(const InputCurve& curve) {
  constexpr int samples = 64;
  std::vector<Vec3> points;
  for (int i = 0; i <= samples; ++i)
    points.push_back(curve.evaluate(curve.start() + (curve.end() - curve.start()) * i / samples));
  return points;
}

// Names that the mirror images of words have: "rail.2" becomes "mirrored rail.2".
class MirrorImages {
 public:
  explicit MirrorImages(const std::vector<CharacterLine>& lines) {
    for (const CharacterLine& line : lines) names_.insert(line.name);
  }
  // The same name for what lies in the plane.
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

void add_mirrored(const Scene& scene, std::vector<CharacterLine>& lines) {
  if (!scene.network.symmetry) return;
  const int axis = *scene.network.symmetry;
  std::vector<std::vector<Vec3>> points;
  Box3 box;
  for (const CharacterLine& line : lines) {
    points.push_back(sampled(*line.curve));
    box.extend(bounding_box(points.back()));
  }
  constexpr double near = 1e-3;  // of the size
  const double tolerance =
      scene.network.tolerance > 0 ? scene.network.tolerance : near * box.diagonal().norm();
  const AffineTransform mirror = reflection_in(Vec3::Zero(), Vec3::Unit(axis));
  const size_t count = lines.size();
  for (size_t i = 0; i < count; ++i) {
    const auto [low, high] =
        std::minmax_element(points[i].begin(), points[i].end(),
                            [axis](const Vec3& a, const Vec3& b) { return a[axis] < b[axis]; });
    if ((*low)[axis] < -tolerance && (*high)[axis] > tolerance)
      throw InputError(scene.at(scene.network.location) + "line '" + lines[i].name +
                       "' crosses the plane of symmetry, from " + format_point(*low) + " to " +
                       format_point(*high) +
                       "; expected lines on one side of it, which end there or lie in it");
    if ((*low)[axis] >= -tolerance && (*high)[axis] <= tolerance) continue;
    CharacterLine twin = lines[i];
    twin.name = kMirrored + twin.name;
    twin.curve = transformed(lines[i].curve, mirror);
    lines.push_back(std::move(twin));
  }
}

std::vector<JoinSpec> mirrored_joins(const Scene& scene, const std::vector<CharacterLine>& lines) {
  const std::vector<JoinSpec>& said = scene.network.joins;
  if (!scene.network.symmetry) return said;
  const MirrorImages images(lines);
  std::vector<JoinSpec> words;
  for (const JoinSpec& word : said)
    if (const std::string twin = images.of(word.line); twin != word.line)
      words.push_back({twin, word.kind, word.where});
  words.insert(words.end(), said.begin(), said.end());  // the user has the last word
  return words;
}

std::vector<RegionSpec> mirrored_regions(const Scene& scene,
                                         const std::vector<CharacterLine>& lines) {
  std::vector<RegionSpec> words = scene.network.regions;
  if (!scene.network.symmetry) return words;
  const MirrorImages images(lines);
  const auto names_of = [](const RegionSpec& word) {
    std::multiset<std::string> names;
    for (const auto& loop : word.loops) names.insert(loop.begin(), loop.end());
    return names;
  };
  for (const RegionSpec& word : scene.network.regions) {
    RegionSpec twin = word;
    bool whole = false;  // names lines of both halves
    for (std::string& name : twin.inner) name = images.of(name);
    for (auto& loop : twin.loops)
      for (std::string& name : loop) {
        whole |= name.starts_with(kMirrored);
        name = images.of(name);
      }
    const bool said =
        std::any_of(scene.network.regions.begin(), scene.network.regions.end(),
                    [&](const RegionSpec& other) { return names_of(other) == names_of(twin); });
    if (whole || said) continue;
    if (!twin.name.empty()) twin.name = kMirrored + twin.name;
    words.push_back(std::move(twin));
  }
  return words;
}

}  // namespace batten
