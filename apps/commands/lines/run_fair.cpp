#include "batten/apps/commands/lines/run_fair.h"

#include <algorithm>

#include "batten/apps/commands/lines/comb_panels.h"
#include "batten/apps/commands/lines/fair_lines.h"
#include "batten/apps/commands/runs/output_folder.h"
#include "batten/apps/commands/runs/run_parts.h"
#include "batten/io/files/length_units.h"
#include "batten/io/files/whole_file.h"
#include "batten/io/pictures/display.h"

namespace batten {
namespace {

std::string first_few(const std::vector<std::string>& names) {
  constexpr size_t few = 5;
  if (names.size() <= few) return listed(names);
  return listed({names.begin(), names.begin() + few}) + " and " +
         std::to_string(names.size() - few) + " more";
}

/// Lines to results and the report about them.
std::vector<FairedResult> fair(const FairScene& scene, FairReport& report, Stopwatch& watch,
                               const Progress& progress) {
  report.name = scene.name;
  report.unit = scene.unit;
  report.parameters = scene.parameters();
  progress.at("lines", 0);
  const auto lines = read_sources(scene.lines, scene.file, scene.unit);
  watch.lap("lines");
  FairingSettings settings;
  settings.stages = scene.stages;
  settings.segments = scene.segments;
  settings.file = scene.file.string();
  auto results = fair_lines(lines, settings, progress);
  std::vector<std::string> restless;
  for (const FairedResult& result : results) {
    report.curves.push_back(result.report);
    if (!result.warning.empty()) report.warnings.push_back(result.warning);
    if (!result.report.settled) restless.push_back(result.report.name);
  }
  if (!restless.empty())
    report.warnings.push_back("parameters still moved in the last round: " + first_few(restless));
  watch.lap("fair");
  return results;
}

void write(const std::filesystem::path& path, const std::vector<FairedResult>& results,
           const FairScene& scene, FairReport& report, const std::string& name) {
  std::vector<NamedCurve> curves;
  for (const FairedResult& result : results) curves.push_back(result.named());
  const auto notes = write_curves(path, curves, unit_in_metres(scene.unit));
  report.warnings.insert(report.warnings.end(), notes.begin(), notes.end());
  report.files.push_back(name);
}

/// Pictures need a display; a result without them is still a result, but not what was asked for.
void draw(const std::filesystem::path& path, const std::vector<FairedResult>& results,
          const FairScene& scene, const CombPictureRule& rule, FairReport& report,
          const std::string& name) {
  const auto missed = [&](const std::string& why) {
    report.missed.push_back({name, "is not drawn: " + why});
  };
  if (std::none_of(results.begin(), results.end(), [](const auto& r) { return r.has_curve(); }))
    return missed("no line has a length");
  try {
    require_display();
  } catch (const InputError& e) {
    return missed(e.what());
  }
  draw_combs(path, comb_panels(results, scene, rule), rule.size);
  report.files.push_back(name);
}

void finish(FairReport& report) {
  const auto broken = broken_promises(report);
  report.missed.insert(report.missed.end(), broken.begin(), broken.end());
}

}  // namespace

void apply_settings(FairScene& scene, const std::vector<std::string>& settings) {
  for (const Setting& s : parsed_settings(settings)) scene.set(s.name, s.value, s.where);
}

FairReport run_fair(const FairScene& scene, const std::filesystem::path& folder,
                    const Progress& progress) {
  OutputFolder out(folder);
  FairReport report;
  Stopwatch watch(report.timings);
  const auto results = fair(scene, report, watch, progress);
  progress.at("files", 0);
  for (const std::string& name : scene.outputs) write(out.file(name), results, scene, report, name);
  watch.lap("files");
  for (const CombPictureRule& rule : scene.pictures)
    draw(out.file(rule.file), results, scene, rule, report, rule.file);
  if (!scene.pictures.empty()) watch.lap("pictures");
  watch.total();
  finish(report);
  report.files.push_back("report.json");
  write_whole_file(out.file("report.json"), [&](std::ostream& text) { text << to_json(report); });
  progress.at("files", 1);
  out.commit();
  return report;
}

FairReport run_fair(const FairScene& scene, const FairFiles& files, const Progress& progress) {
  // Folders that are missing or not writable, found out before the work is done.
  for (const auto& path : {files.out, files.picture, files.report})
    if (!path.empty()) WholeFile probe(path);
  FairReport report;
  Stopwatch watch(report.timings);
  const auto results = fair(scene, report, watch, progress);
  progress.at("files", 0);
  write(files.out, results, scene, report, files.out.string());
  watch.lap("files");
  if (!files.picture.empty()) {
    draw(files.picture, results, scene, {}, report, files.picture.string());
    watch.lap("pictures");
  }
  watch.total();
  finish(report);
  if (!files.report.empty()) {
    report.files.push_back(files.report.string());
    write_whole_file(files.report, [&](std::ostream& text) { text << to_json(report); });
  }
  return report;
}

}  // namespace batten
