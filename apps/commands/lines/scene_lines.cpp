#include "batten/apps/commands/lines/scene_lines.h"

#include <algorithm>

#include "batten/apps/commands/lines/fair_lines.h"
#include "batten/apps/commands/lines/line_files.h"
#include "batten/core/errors.h"
#include "batten/skinning/network/curve_network.h"
#include "batten/skinning/surfaces/mirror_images.h"

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
      if (!faired[k].report.was_noisy(freehand)) continue;
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

void add_mirrored(const Scene& scene, std::vector<CharacterLine>& lines) {
  if (!scene.network.symmetry) return;
  try {
    add_mirror_images({Vec3::Zero(), Vec3::Unit(*scene.network.symmetry), scene.network.tolerance},
                      lines);
  } catch (const InputError& e) {
    throw InputError(scene.at(scene.network.location) + e.what());
  }
}

std::vector<JoinSpec> mirrored_joins(const Scene& scene, const std::vector<CharacterLine>& lines) {
  return scene.network.symmetry ? with_mirror_images(scene.network.joins, lines)
                                : scene.network.joins;
}

std::vector<RegionSpec> mirrored_regions(const Scene& scene,
                                         const std::vector<CharacterLine>& lines) {
  return scene.network.symmetry ? with_mirror_images(scene.network.regions, lines)
                                : scene.network.regions;
}

}  // namespace batten
