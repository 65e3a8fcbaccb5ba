#include "batten/io/lines/drawing.h"

#include <algorithm>

#include "batten/core/errors.h"
#include "batten/io/files/input_file.h"
#include "batten/io/files/text.h"
#include "batten/io/lines/named_lines.h"

namespace batten {

std::shared_ptr<const InputCurve> straight_segment(const Vec3& a, const Vec3& b) {
  return bezier_curve(a, a + (b - a) / 3, b - (b - a) / 3, b);
}

DrawnLine transformed(const DrawnLine& line, const AffineTransform& transform) {
  DrawnLine result = line;
  for (Vec3& p : result.points) p = transform(p);
  if (line.curve) result.curve = transformed(line.curve, transform);
  return result;
}

void SkippedEntities::report_to(Drawing& drawing) const {
  std::string text;
  for (const auto& [kind, count] : count_)
    text += (text.empty() ? "" : ", ") + std::to_string(count) + " " + kind;
  if (!text.empty()) drawing.notes.push_back("skipped: " + text);
}

Drawing read_drawing(const std::filesystem::path& path) {
  const std::string ending = lower_extension(path);
  if (ending != ".dxf" && ending != ".svg")
    throw InputError(path.string() + ": found the extension '" + ending +
                     "', expected .dxf or .svg");
  require_input_file(path, "a drawing");
  Drawing drawing = ending == ".dxf" ? read_dxf(path) : read_svg(path);
  const auto finite = [](const Vec3& p) { return p.allFinite() && p.norm() < 1e100; };
  size_t without_length = drawing.lines.size();
  std::erase_if(drawing.lines, [](const DrawnLine& line) {
    return !line.curve && std::all_of(line.points.begin(), line.points.end(),
                                      [&](const Vec3& p) { return p == line.points[0]; });
  });
  without_length -= drawing.lines.size();
  if (without_length > 0)
    drawing.notes.push_back("skipped: " + std::to_string(without_length) +
                            " curves of zero length");
  if (drawing.lines.empty()) {
    std::string notes;
    for (const std::string& note : drawing.notes) notes += " (" + note + ")";
    throw InputError(path.string() + ": found no curve" + notes + ", expected at least one");
  }
  std::vector<std::string*> names;
  for (DrawnLine& line : drawing.lines) {
    const bool good = line.curve ? finite(line.curve->evaluate(line.curve->start())) &&
                                       finite(line.curve->evaluate(line.curve->end()))
                                 : std::all_of(line.points.begin(), line.points.end(), finite);
    if (!good)
      throw InputError(path.string() + ": found coordinates in '" + line.name +
                       "' that are not finite or too large, expected numbers below 1e100");
    names.push_back(&line.name);
  }
  make_names_unique(names, path.stem().string());
  return drawing;
}

}  // namespace batten
