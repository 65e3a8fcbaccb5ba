#include "batten/apps/commands/lines/fair_lines.h"

#include <algorithm>
#include <utility>

#include "batten/apps/commands/lines/line_files.h"
#include "batten/apps/commands/runs/run_support.h"
#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/parallel.h"

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

}  // namespace batten
