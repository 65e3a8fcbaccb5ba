// The table that `batten fair` prints.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "batten/apps/commands/lines/run_fair.h"
#include "batten/apps/commands/runs/run_parts.h"

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

/// UTF-8 letters, not bytes.
size_t width_of(const std::string& text) {
  return static_cast<size_t>(std::count_if(text.begin(), text.end(), [](char c) {
    return (static_cast<unsigned char>(c) & 0xC0) != 0x80;
  }));
}

using Row = std::vector<std::string>;

Row row_of(const FairedLine& c) {
  Row row = {c.name, std::to_string(c.points)};
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
  sum.name = std::to_string(curves.size()) + " lines";
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

}  // namespace

std::string summary(const FairReport& report) {
  constexpr size_t most = 20;
  std::vector<Row> rows = {{"line", "points", "segments", "deviation", "rms", "extrema",
                            "inflections", "wavelength", "ms"}};
  const size_t shown = std::min(most, report.curves.size());
  for (size_t i = 0; i < shown; ++i) rows.push_back(row_of(report.curves[i]));
  if (report.curves.size() > 1) rows.push_back(total_of(report.curves));
  std::vector<size_t> widths(rows.front().size(), 0);
  for (const Row& row : rows)
    for (size_t k = 0; k < row.size(); ++k) widths[k] = std::max(widths[k], width_of(row[k]));
  std::string text = report.name + ", lengths in " + report.unit + "\n";
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
  return text + result_ending(report, folder);
}

}  // namespace batten
