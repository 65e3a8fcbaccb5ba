#include <algorithm>

#include "batten/apps/commands/runs/run_support.h"
#include "batten/apps/commands/sequences/run_sequence.h"
#include "batten/core/format.h"
#include "batten/io/files/text.h"

namespace batten {
namespace {

/// Numbered frames by the first and the last of them.
std::vector<std::string> in_short(const std::vector<std::string>& files) {
  std::vector<std::string> text;
  const auto alike = [&](size_t a, size_t b) {
    const std::filesystem::path p = files[a], q = files[b];
    return p.parent_path() == q.parent_path() && p.extension() == q.extension();
  };
  for (size_t from = 0; from < files.size();) {
    size_t to = from;
    while (to + 1 < files.size() && alike(from, to + 1)) ++to;
    if (to - from < 4) {
      text.insert(text.end(), files.begin() + static_cast<long>(from),
                  files.begin() + static_cast<long>(to) + 1);
    } else {
      text.push_back(files[from] + " … " + files[to] + " (" + std::to_string(to - from + 1) +
                     " files)");
    }
    from = to + 1;
  }
  return text;
}

}  // namespace

std::string summary(const SequenceReport& report, const std::filesystem::path& folder) {
  std::string text = report.name + "\n";
  text += summary_line("sequence", std::to_string(report.frames_before) + " frames, " +
                                       std::to_string(report.nodes) + " nodes, " +
                                       std::to_string(report.faces) + " faces");
  for (const auto& s : report.steps)
    text += summary_line("step", s.name + " (" + s.kind + "): " + std::to_string(s.frames) +
                                     " frames, " + format_count(s.keyframes, "keyframe") + ", " +
                                     format_number(s.seconds) + " s");
  text += summary_line(
      "frames",
      std::to_string(report.first) + " to " + std::to_string(report.last) + " of " +
          std::to_string(report.frames) +
          (report.found > 0 ? ", " + std::to_string(report.found) + " of them were there" : ""));
  if (!report.feet.empty()) {
    double before = 0, after = 0;
    for (const auto& f : report.feet) {
      before = std::max(before, f.foot_skate_before);
      after = std::max(after, f.foot_skate);
    }
    text += summary_line("footprints", std::to_string(report.feet.size()) + ", slip " +
                                           format_number(before) + " -> " + format_number(after) +
                                           " of the size");
  }
  double rigid = 0;
  for (const auto& f : report.features) rigid = std::max(rigid, f.max_rigid_error);
  if (!report.features.empty())
    text += summary_line("features", std::to_string(report.features.size()) + ", rigid to " +
                                         format_number(rigid) + " of their size");
  text += summary_line("smoothness", "largest second difference " +
                                         format_number(report.second_difference_before) + " -> " +
                                         format_number(report.second_difference) + " " +
                                         report.unit + ", triangles turned over " +
                                         std::to_string(report.inverted_triangles_before) + " -> " +
                                         std::to_string(report.inverted_triangles));
  RunReport shown = report;
  shown.files = in_short(report.files);
  return text + summary_footer(shown, folder);
}

}  // namespace batten
