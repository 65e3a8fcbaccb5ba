// SPDX-License-Identifier: MPL-2.0
#include "batten/scenes/commands.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include "batten/core/cancellation.h"
#include "batten/core/containers.h"
#include "batten/io/files/command_files.h"
#include "batten/io/files/text.h"
#include "batten/io/pictures/comb_pictures.h"
#include "batten/scenes/lines/scene_lines.h"
#include "batten/scenes/runs/run_support.h"

namespace batten {
namespace {

std::string short_number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

std::string from_to(int before, int after) {
  return std::to_string(before) + " -> " + std::to_string(after);
}

/// Number of UTF-8 characters.
size_t width_of(const std::string& text) {
  return static_cast<size_t>(std::count_if(text.begin(), text.end(), [](char c) {
    return (static_cast<unsigned char>(c) & 0xC0) != 0x80;
  }));
}

using Row = std::vector<std::string>;

Row row_of(const FairedLine& c) {
  Row row = {printable(c.name), std::to_string(c.points)};
  if (!c.before || !c.after) {
    row.insert(row.end(), {"-", "-", "-", "-", "-", "-", "-"});
    return row;
  }
  row.insert(row.end(),
             {std::to_string(c.segments), short_number(c.deviation.max),
              short_number(c.deviation.rms), from_to(c.before->extrema, c.after->extrema),
              from_to(c.before->inflections, c.after->inflections),
              c.wavelength > 0 ? short_number(c.wavelength) : "-", short_number(1000 * c.seconds)});
  return row;
}

Row total_of(const std::vector<FairedLine>& curves) {
  FairedLine sum;
  sum.name = std::to_string(curves.size()) + " curves";
  sum.before.emplace();
  sum.after.emplace();
  double squares = 0;
  for (const FairedLine& c : curves) {
    sum.points += c.points;
    sum.segments += c.segments;
    sum.seconds += c.seconds;
    sum.deviation.max = std::max(sum.deviation.max, c.deviation.max);
    squares += c.points * c.deviation.rms * c.deviation.rms;
    for (auto [all, one] : {std::pair(&sum.before, &c.before), std::pair(&sum.after, &c.after)})
      if (*one) {
        (*all)->extrema += (*one)->extrema;
        (*all)->inflections += (*one)->inflections;
      }
  }
  if (sum.points > 0) sum.deviation.rms = std::sqrt(squares / sum.points);
  return row_of(sum);
}

/// Numbers of curvature extrema and inflections of all curves after a stage, as text for a caption.
std::string counts(const std::vector<FairedResult>& results, size_t state) {
  int extrema = 0, inflections = 0;
  for (const FairedResult& result : results) {
    if (!result.has_curve()) continue;
    const Fairness f = fairness(result.states[state], result.scales[state]);
    extrema += f.extrema;
    inflections += f.inflections;
  }
  const auto said = [](int n, const std::string& noun, const std::string& many) {
    return std::to_string(n) + " " + (n == 1 ? noun : many);
  };
  return said(extrema, "extremum", "extrema") + ", " +
         said(inflections, "inflection", "inflections");
}

/// The panels of a [[picture]]. Combs: the curves as given and after all stages. Stages: the curves
/// as given, after each non-local stage, and after each group of consecutive local stages. Lines
/// without length are drawn as dots. At least one result must have a curve.
CombPicture comb_panels(const std::vector<FairedResult>& results, const FairScene& scene,
                        const CombPictureSpec& rule) {
  CombPicture picture;
  picture.unit = scene.unit;
  picture.view = rule.view;
  const auto add = [&](size_t state, const std::string& title) -> CombPanel& {
    CombPanel panel;
    for (const FairedResult& result : results) {
      if (result.has_curve()) panel.curves.push_back(result.states[state]);
      if (rule.points || !result.has_curve())
        panel.points.insert(panel.points.end(), result.points.begin(), result.points.end());
    }
    panel.title =
        (rule.title.empty() ? "" : rule.title + ", ") + title + ": " + counts(results, state);
    picture.panels.push_back(std::move(panel));
    return picture.panels.back();
  };
  const auto& stages = scene.stages;
  if (rule.show == CombPictureSpec::Show::Combs) {
    add(0, "before");
    add(stages.size(), "after");
  } else {
    add(0, "as given");
    for (size_t s = 0; s < stages.size(); ++s) {
      std::string names = stages[s].name;
      const size_t first = s;
      while (stages[s].local() && s + 1 < stages.size() && stages[s + 1].local())
        names += ", " + stages[++s].name;
      CombPanel& panel = add(s + 1, names);
      for (size_t k = first; k <= s; ++k)
        if (stages[k].brush)
          panel.spheres.emplace_back(stages[k].brush->at, stages[k].brush->radius);
    }
  }
  picture.scale_panel = isize(picture.panels) - 1;
  return picture;
}

/// Fairs the lines, and fills the report.
std::vector<FairedResult> fair(const FairScene& scene, FairReport& report, Stopwatch& watch,
                               const Progress& progress) {
  report.name = scene.name;
  report.unit = scene.unit;
  report.parameters = scene.parameters();
  progress.update("curves", 0);
  const auto lines = read_sources(scene.lines, scene.file, scene.unit);
  watch.lap("curves");
  FairingSettings settings;
  settings.stages = scene.stages;
  settings.segments = scene.segments;
  settings.file = scene.file.string();
  auto results = fair_lines(lines, settings, progress);
  for (const SourceLine& line : lines)
    report.warnings.insert(report.warnings.end(), line.warnings.begin(), line.warnings.end());
  std::vector<std::string> restless;
  for (const FairedResult& result : results) {
    report.curves.push_back(result.report);
    if (!result.warning.empty()) report.warnings.push_back(result.warning);
    report.warnings.insert(report.warnings.end(), result.notes.begin(), result.notes.end());
    if (!result.report.converged) restless.push_back(result.report.name);
    const FairedLine& line = result.report;
    if (const std::string text = describe_outliers(line); !text.empty())
      report.warnings.push_back(text);
    constexpr double more = 3;     // warn above this multiple of the noise
    constexpr double seen = 1e-6;  // relative to the line's size; smaller displacements are not
                                   // reported
    if (settings.segments == 0 && line.noise > 0 &&
        line.deviation.rms > std::max(more * line.noise, seen * line.size))
      report.warnings.push_back(
          "'" + line.name + "' has moved by " + format_number(line.deviation.rms) +
          " (RMS), but the noise of its points is about " + format_number(line.noise) + " " +
          scene.unit + ": a shorter wavelength or a smaller deviation preserves more of it");
  }
  if (!restless.empty())
    report.warnings.push_back("fairing did not converge: " + first_few(restless));
  watch.lap("fair");
  return results;
}

void write(const std::filesystem::path& path, const std::vector<FairedResult>& results,
           const FairScene& scene, FairReport& report, const std::string& name) {
  std::vector<NamedCurve> curves;
  for (const FairedResult& result : results) curves.push_back(result.named());
  const auto notes = write_curves(path, curves, {unit_in_metres(scene.unit)});
  report.warnings.insert(report.warnings.end(), notes.begin(), notes.end());
  report.files.push_back(name);
}

void draw(const std::filesystem::path& path, const std::vector<FairedResult>& results,
          const FairScene& scene, const CombPictureSpec& rule, FairReport& report,
          const std::string& name) {
  if (std::none_of(results.begin(), results.end(), [](const auto& r) { return r.has_curve(); })) {
    report.failed_checks.push_back({name, "is not drawn: no curve has a length"});
    return;
  }
  if (!can_draw(report, name)) return;
  draw_combs(path, comb_panels(results, scene, rule), rule.size);
  report.files.push_back(name);
}

}  // namespace

std::string summary(const FairReport& report) {
  constexpr size_t most = 20;
  std::vector<Row> rows = {{"curve", "points", "segments", "deviation", "rms", "extrema",
                            "inflections", "wavelength", "ms"}};
  const size_t shown = std::min(most, report.curves.size());
  for (size_t i = 0; i < shown; ++i) rows.push_back(row_of(report.curves[i]));
  if (report.curves.size() > 1) rows.push_back(total_of(report.curves));
  std::vector<size_t> widths(rows.front().size(), 0);
  for (const Row& row : rows)
    for (size_t k = 0; k < row.size(); ++k) widths[k] = std::max(widths[k], width_of(row[k]));
  std::string text = printable(report.name) + ", lengths in " + report.unit + "\n";
  for (const Row& row : rows) {
    if (&row == &rows.back() && shown < report.curves.size())
      text += "  ... " + std::to_string(report.curves.size() - shown) + " more\n";
    text += " ";
    for (size_t k = 0; k < row.size(); ++k) {
      const std::string pad(widths[k] - width_of(row[k]), ' ');
      text += " " + (k == 0 ? row[k] + pad : " " + pad + row[k]);
    }
    text += "\n";
  }
  return text;
}

std::string summary(const FairReport& report, const std::filesystem::path& folder) {
  std::string text = summary(report);
  return text + summary_footer(report, folder);
}

FairReport run_fair(const FairScene& scene, const std::filesystem::path& folder,
                    const Progress& progress) {
  const ProgressScope scope(progress);
  const CommandFiles files;
  record_input(scene.file);
  OutputFolder out(folder);
  FairReport report;
  Stopwatch watch(report.timings);
  const auto results = fair(scene, report, watch, progress);
  progress.update("files", 0);
  for (const std::string& name : scene.outputs) write(out.file(name), results, scene, report, name);
  watch.lap("files");
  for (const CombPictureSpec& rule : scene.pictures)
    draw(out.file(rule.file), results, scene, rule, report, rule.file);
  if (!scene.pictures.empty()) watch.lap("pictures");
  watch.total();
  write_report(report, failed_checks(report), out, progress);
  out.commit();
  return report;
}

FairReport run_fair(const FairScene& scene, const FairFiles& files, const Progress& progress) {
  const ProgressScope scope(progress);
  const CommandFiles protected_inputs;
  for (const SceneLine& line : scene.lines) record_input(line.file);
  // Created before the computation, which then does not run in vain for a read-only folder.
  std::optional<AtomicFile> out, picture, report_file;
  std::vector<const AtomicFile*> all;
  for (const auto& [path, file] : {std::pair(&files.out, &out), std::pair(&files.picture, &picture),
                                   std::pair(&files.report, &report_file)})
    if (!path->empty()) all.push_back(&file->emplace(*path));
  require_distinct(all);
  FairReport report;
  Stopwatch watch(report.timings);
  const auto results = fair(scene, report, watch, progress);
  progress.update("files", 0);
  write(out->temporary(), results, scene, report, files.out.string());
  watch.lap("files");
  if (picture) {
    draw(picture->temporary(), results, scene, {}, report, files.picture.string());
    watch.lap("pictures");
  }
  watch.total();
  const auto broken = failed_checks(report);
  report.failed_checks.insert(report.failed_checks.end(), broken.begin(), broken.end());
  if (report_file) {
    report.files.push_back(files.report.string());
    report_file->write([&](std::ostream& text) { text << to_json(report); });
  }
  commit_together(all);
  return report;
}

}  // namespace batten
