// SPDX-License-Identifier: MPL-2.0
#include "batten/scenes/lines/scene_lines.h"

#include <algorithm>
#include <utility>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/parallel.h"
#include "batten/scenes/lines/scene_neighbours.h"
#include "batten/scenes/runs/run_support.h"
#include "batten/skinning/network/curve_network.h"
#include "batten/skinning/surfaces/mirror_images.h"

namespace batten {
namespace {

/// Numbers of the lines that the names of a stage match; empty: all.
std::vector<int> curves_of(const SceneFairStage& stage, const std::string& file,
                           const std::vector<SourceLine>& lines) {
  std::vector<std::string> names;
  for (const SourceLine& line : lines) names.push_back(line.name);
  std::vector<int> curves;
  for (const LocatedString& word : stage.lines) {
    bool any = false;
    for (size_t i = 0; i < names.size(); ++i) {
      if (!matches_wildcard(word.text, names[i])) continue;
      any = true;
      curves.push_back(static_cast<int>(i));
    }
    if (!any)
      throw InputError(format_location(file, word.location) + "found the curve name '" + word.text +
                       "', expected " + expected_one_of(word.text, names));
  }
  return sorted_unique(std::move(curves));
}

/// The stage with the lines that it applies to, the default of `fix_ends` and its location.
FairStage fair_stage(const SceneFairStage& given, const FairingSettings& settings,
                     const std::vector<SourceLine>& lines) {
  FairStage stage = given;
  stage.curves = curves_of(given, settings.file, lines);
  stage.options.fix_ends = given.fix_ends.value_or(settings.fix_ends);
  stage.where =
      format_location(settings.file, given.location) + "the [[fair]] stage '" + given.name + "': ";
  return stage;
}

/// Samples all lines, in batches. Between batches this thread reports progress and can cancel.
std::vector<CurveSamples> sample(const std::vector<SourceLine>& lines,
                                 const std::vector<FairStage>& stages, const Progress& progress) {
  std::vector<CurveSamples> samples(lines.size());
  constexpr size_t batch = 64;
  for (size_t first = 0; first < lines.size(); first += batch) {
    progress.update("reading curves",
                    static_cast<double>(first) / static_cast<double>(lines.size()));
    parallel_for(static_cast<int>(std::min(batch, lines.size() - first)), [&](int part) {
      const size_t i = first + static_cast<size_t>(part);
      samples[i] = sample_line(lines[i], corner_angle_of(stages, static_cast<int>(i)));
    });
  }
  return samples;
}

}  // namespace

NamedCurve FairedResult::named() const {
  if (!has_curve()) return {report.name, {}, {}, points};
  return {report.name, states.back(), parameters, {}};
}

std::string first_few(const std::vector<std::string>& names) {
  constexpr size_t few = 5;
  if (names.size() <= few) return comma_separated(names);
  return comma_separated({names.begin(), names.begin() + few}) + " and " +
         std::to_string(names.size() - few) + " more";
}

std::string describe_outliers(const FairedLine& line) {
  if (line.outliers.empty()) return "";
  std::vector<std::string> numbers;
  for (const int i : line.outliers) numbers.push_back(std::to_string(i + 1));
  const bool one = numbers.size() == 1;
  return "'" + line.name + "': " + (one ? "point " : "points ") + first_few(numbers) +
         (one ? " lies" : " lie") + " off the curve by more than its noise and " +
         (one ? "was ignored as an outlier" : "were ignored as outliers") +
         " (outliers = \"keep\" keeps " + (one ? "it)" : "them)");
}

std::vector<FairedResult> fair_lines(const std::vector<SourceLine>& lines,
                                     const FairingSettings& settings, const Progress& progress) {
  std::vector<FairStage> stages;
  for (const SceneFairStage& stage : settings.stages)
    stages.push_back(fair_stage(stage, settings, lines));
  const std::vector<CurveSamples> samples = sample(lines, stages, progress);
  std::vector<StagedFairingResult> faired =
      fair_in_stages(samples, stages, settings.segments, progress);
  std::vector<FairedResult> results(lines.size());
  for (size_t i = 0; i < lines.size(); ++i) {
    FairedResult& result = results[i];
    static_cast<StagedFairingResult&>(result) = std::move(faired[i]);
    result.role = lines[i].role;
    result.points = samples[i].points;
    if (!result.rejection_reason.empty())
      result.warning =
          "curve '" + lines[i].name + "' has " + result.rejection_reason + " and is not faired";
  }
  return results;
}

namespace {

class SceneLines {
 public:
  SceneLines(const Scene& scene, const Progress& progress)
      : scene_(scene),
        progress_(progress),
        sources_(read_sources(scene)),
        texts_(sources_.size()) {}

  FairedLines run() && {
    if (!scene_.fairing.empty()) {
      take(fair_as_requested());
    } else {
      for (size_t i = 0; i < sources_.size(); ++i) add_unfaired(i);
      if (scene_.network.fair_noisy_lines && only_outlines()) fair_noisy_lines();
    }
    add_mirrored(scene_, result_.lines);
    for (const SourceLine& source : sources_) {
      result_.reading_notes.insert(result_.reading_notes.end(), source.notes.begin(),
                                   source.notes.end());
      result_.warnings.insert(result_.warnings.end(), source.warnings.begin(),
                              source.warnings.end());
    }
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
      result_.warnings.insert(result_.warnings.end(), result.notes.begin(), result.notes.end());
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
    return joined_fraction(result_.lines, options) < prepared;
  }

  // The lines given by points whose corners are to be detected, and their indices.
  std::pair<std::vector<SourceLine>, std::vector<size_t>> drawn() const {
    std::pair<std::vector<SourceLine>, std::vector<size_t>> drawn;
    for (size_t i = 0; i < sources_.size(); ++i) {
      if (sources_[i].points.empty()) continue;
      const auto known = sources_[i].known_corners(scene_.skin.options.corner_angle);
      if (known && (sources_[i].corners || !known->empty())) continue;
      drawn.first.push_back(sources_[i]);
      drawn.second.push_back(i);
    }
    return drawn;
  }

  void fair_noisy_lines() {
    const auto [lines, numbers] = drawn();
    if (lines.empty()) return;
    FairingSettings all = settings();
    FairOptions& options = all.stages.emplace_back().options;
    options.corner_angle = scene_.skin.options.corner_angle;
    options.drawn_by_hand = true;  // only lines that prove noisy are replaced
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
  FairedLines faired = SceneLines(scene, progress).run();
  for (CharacterLine& line : read_neighbours(scene).lines) faired.lines.push_back(std::move(line));
  return faired;
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
