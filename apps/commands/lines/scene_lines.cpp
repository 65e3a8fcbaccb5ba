#include "batten/apps/commands/lines/scene_lines.h"

#include <algorithm>
#include <set>

#include "batten/apps/commands/lines/fair_lines.h"
#include "batten/apps/commands/lines/line_files.h"
#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/fairing/curves/primitive_curves.h"
#include "batten/skinning/network/curve_network.h"

namespace batten {
namespace {

class SceneLines {
 public:
  SceneLines(const Scene& scene, const Progress& progress)
      : scene_(scene),
        progress_(progress),
        sources_(read_sources(scene.lines, scene.file, scene.unit)),
        texts_(sources_.size()) {}

  FairedLines run() && {
    result_.reading_notes = scene_.notes;
    if (!scene_.fairing.empty()) {
      take(fair_as_requested());
    } else {
      for (size_t i = 0; i < sources_.size(); ++i) add_unfaired(i);
      if (scene_.network.fair_noisy_lines && only_outlines()) fair_noisy_lines();
    }
    add_mirrored(scene_, result_.lines);
    for (std::string& text : texts_)
      if (!text.empty()) result_.reading_notes.push_back(std::move(text));
    return std::move(result_);
  }

 private:
  FairingSettings settings() const {
    FairingSettings settings;
    settings.stages = scene_.fairing;
    settings.fix_ends = true;
    settings.file = scene_.file.string();
    return settings;
  }

  std::vector<FairedResult> fair_as_requested() const {
    return fair_lines(sources_, settings(), progress_);
  }

  void add_unfaired(size_t i) {
    result_.lines.push_back(character_line(sources_[i], scene_.skin.options.corner_angle));
    texts_[i] = reading_note(sources_[i], *result_.lines.back().curve);
  }

  static CharacterLine faired_line(const SourceLine& source, const FairedResult& result) {
    return {source.name, curve_from_hermite(result.states.back()), source.role,
            source.mesh_alignment};
  }

  void take(const std::vector<FairedResult>& results) {
    for (size_t i = 0; i < sources_.size(); ++i) {
      const FairedResult& result = results[i];
      if (!result.warning.empty())
        throw InputError(sources_[i].at + result.warning + ", expected curves with a length");
      if (!result.report.faired) {
        add_unfaired(i);
        continue;
      }
      result_.lines.push_back(faired_line(sources_[i], result));
      result_.reports.push_back(result.report);
      texts_[i] = describe_outliers(result.report);
    }
  }

  // True if no curve has a role or mesh alignment, which indicate a prepared file.
  bool only_outlines() const {
    return std::all_of(sources_.begin(), sources_.end(), [](const SourceLine& source) {
      return source.role == CharacterLine::Role::Outline &&
             source.mesh_alignment == CharacterLine::MeshAlignment::Auto;
    });
  }

  // True if the gaps between ends are typical of hand-drawn lines.
  bool is_freehand() const {
    constexpr double prepared = 0.5;
    NetworkOptions options;
    options.corner_angle = scene_.skin.options.corner_angle;
    return CurveNetwork(result_.lines, options, progress_).joined_fraction() < prepared;
  }

  static bool is_noisy(const FairedLine& line, bool is_freehand) {
    if (!line.faired || !line.before || !line.after) return false;
    constexpr int most_left = 3, fewest = 4;
    const int gone = line.before->extrema - line.after->extrema;
    if (is_freehand) return gone > 0;
    return line.noise > 0 && gone >= fewest &&
           most_left * line.after->extrema <= line.before->extrema;
  }

  // The lines given by points, and their indices.
  std::pair<std::vector<SourceLine>, std::vector<size_t>> drawn() const {
    std::pair<std::vector<SourceLine>, std::vector<size_t>> drawn;
    for (size_t i = 0; i < sources_.size(); ++i) {
      if (sources_[i].points.empty()) continue;
      drawn.first.push_back(sources_[i]);
      drawn.second.push_back(i);
    }
    return drawn;
  }

  void fair_noisy_lines() {
    const auto [lines, numbers] = drawn();
    if (lines.empty()) return;
    FairingSettings all = settings();
    all.stages.emplace_back().options.corner_angle = scene_.skin.options.corner_angle;
    const bool freehand = is_freehand();
    std::vector<FairedResult> faired;
    try {
      faired = fair_lines(lines, all, progress_);
    } catch (const CancelledError&) {
      throw;
    } catch (const Error&) {
      return;  // fairing was not requested: keep the curves as given
    }
    std::vector<std::string> names;
    for (size_t k = 0; k < faired.size(); ++k) {
      if (!is_noisy(faired[k].report, freehand)) continue;
      result_.lines[numbers[k]] = faired_line(lines[k], faired[k]);
      result_.reports.push_back(faired[k].report);
      texts_[numbers[k]] = describe_outliers(faired[k].report);
      names.push_back(lines[k].name);
    }
    if (!names.empty()) result_.reading_notes.push_back(describe_faired(names));
  }

  static std::string describe_faired(const std::vector<std::string>& names) {
    const bool one = names.size() == 1;
    return first_few(names) + (one ? " is noisy and was faired" : " are noisy and were faired") +
           " (noisy_curves = \"keep\" in [skin] keeps " + (one ? "it" : "them") + " as given)";
  }

  const Scene& scene_;
  const Progress& progress_;
  std::vector<SourceLine> sources_;
  std::vector<std::string> texts_;  // reading notes, per line
  FairedLines result_;
};

}  // namespace

FairedLines faired_lines(const Scene& scene, const Progress& progress) {
  return SceneLines(scene, progress).run();
}

namespace {

const std::string kMirrored = "mirrored ";

std::vector<Vec3> sampled(const InputCurve& curve) {
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

void add_mirrored(const Scene& scene, std::vector<CharacterLine>& lines) {
  if (!scene.network.symmetry) return;
  const int axis = *scene.network.symmetry;
  std::vector<std::vector<Vec3>> points;
  Box3 box;
  for (const CharacterLine& line : lines) {
    points.push_back(sampled(*line.curve));
    box.extend(bounding_box(points.back()));
  }
  constexpr double near = 1e-3;  // relative to the size
  const double tolerance =
      scene.network.tolerance > 0 ? scene.network.tolerance : near * box.diagonal().norm();
  const AffineTransform mirror = reflection_in(Vec3::Zero(), Vec3::Unit(axis));
  const size_t count = lines.size();
  for (size_t i = 0; i < count; ++i) {
    const auto [low, high] =
        std::minmax_element(points[i].begin(), points[i].end(),
                            [axis](const Vec3& a, const Vec3& b) { return a[axis] < b[axis]; });
    if ((*low)[axis] < -tolerance && (*high)[axis] > tolerance)
      throw InputError(scene.at(scene.network.location) + "found the curve '" + lines[i].name +
                       "', which crosses the plane of symmetry from " + format_point(*low) +
                       " to " + format_point(*high) +
                       ", expected curves that lie on one side of the plane or in it");
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
  words.insert(words.end(), said.begin(), said.end());  // specifications of the user come last and
                                                        // take precedence
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
    bool whole = false;  // contains lines of both halves
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
