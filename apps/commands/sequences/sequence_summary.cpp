#include <algorithm>

#include "batten/apps/commands/runs/run_parts.h"
#include "batten/apps/commands/sequences/run_sequence.h"
#include "batten/core/words.h"
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
  text += result_line("sequence", std::to_string(report.frames_before) + " frames, " +
                                      std::to_string(report.nodes) + " nodes, " +
                                      std::to_string(report.faces) + " faces");
  for (const auto& s : report.steps)
    text += result_line("step", s.name + " (" + s.kind + "): " + std::to_string(s.frames) +
                                    " frames, " + counted(s.keyframes, "keyframe") + ", " +
                                    number(s.seconds) + " s");
  text += result_line(
      "frames",
      std::to_string(report.first) + " to " + std::to_string(report.last) + " of " +
          std::to_string(report.frames) +
          (report.found > 0 ? ", " + std::to_string(report.found) + " of them were there" : ""));
  if (!report.feet.empty()) {
    double before = 0, after = 0;
    for (const auto& f : report.feet) {
      before = std::max(before, f.slip_before);
      after = std::max(after, f.slip);
    }
    text += result_line("footprints", std::to_string(report.feet.size()) + ", slip " +
                                          number(before) + " -> " + number(after) + " of the size");
  }
  double rigid = 0;
  for (const auto& f : report.features) rigid = std::max(rigid, f.max_rigid_error);
  if (!report.features.empty())
    text += result_line("features", std::to_string(report.features.size()) + ", rigid to " +
                                        number(rigid) + " of their size");
  text += result_line("smoothness",
                      "largest second difference " + number(report.second_difference_before) +
                          " -> " + number(report.second_difference) + " " + report.unit +
                          ", triangles turned over " + std::to_string(report.turned_over_before) +
                          " -> " + std::to_string(report.turned_over));
  RunReport shown = report;
  shown.files = in_short(report.files);
  return text + result_ending(shown, folder);
}

}  // namespace batten
