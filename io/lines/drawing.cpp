// SPDX-License-Identifier: MPL-2.0
#include "batten/io/lines/drawing.h"

#include <algorithm>
#include <set>

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

bool is_straight(const BezierCubic<Vec3>& cubic) {
  const auto& b = cubic.b;
  const Vec3 chord = b[3] - b[0];
  const double length = chord.norm();
  if (!(length > 0)) return false;
  const double rounding = 1e-12 * std::max(b[0].norm(), b[3].norm());
  const auto between = [&](const Vec3& p) {
    const double along = (p - b[0]).dot(chord) / length;
    return along >= -rounding && along <= length + rounding &&
           (p - b[0]).cross(chord).norm() <= rounding * length;
  };
  return between(b[1]) && between(b[2]);
}

std::vector<Vec3> polyline_vertices(const NamedCurve& curve) {
  if (!curve.has_curve()) return curve.points;
  std::vector<Vec3> vertices = {curve.curve.bezier(0).b[0]};
  for (int s = 0; s < curve.curve.segment_count(); ++s) {
    const BezierCubic<Vec3> cubic = curve.curve.bezier(s);
    if (!is_straight(cubic)) return {};
    vertices.push_back(cubic.b[3]);
  }
  return vertices;
}

Box3 drawing_box(const std::vector<NamedCurve>& curves) {
  Box3 box;
  for (const NamedCurve& curve : curves) {
    for (const Vec3& p : curve.has_curve() ? std::vector<Vec3>{} : curve.points) box.extend(p);
    for (int s = 0; s < curve.curve.segment_count(); ++s)
      for (const Vec3& p : curve.curve.bezier(s).b) box.extend(p);
  }
  return box;
}

namespace {

// True for kinds of entities of which nobody expects a curve: annotations, images, and entities
// that are not visible in the model.
bool contains_no_curve(const std::string& kind) {
  static const std::set<std::string> kinds = {
      "ACAD_TABLE", "ARCALIGNEDTEXT", "ARC_DIMENSION", "ATTDEF",        "ATTRIB",
      "DIMENSION",  "HATCH",          "IMAGE",         "LEADER",        "MLEADER",
      "MPOLYGON",   "MTEXT",          "MULTILEADER",   "OLE2FRAME",     "OLEFRAME",
      "POINT",      "RTEXT",          "SOLID",         "TEXT",          "TOLERANCE",
      "TRACE",      "VIEWPORT",       "WIPEOUT",       "foreignObject", "image",
      "text"};
  const auto has = [&](const char* words) { return kind.find(words) != std::string::npos; };
  return kinds.contains(kind) || has(" in paper space") || has(" off or frozen") ||
         has(" invisible") || has(" of zero ") || has(" without size");
}

}  // namespace

void SkippedEntities::report_to(Drawing& drawing) const {
  std::string notes, warnings;
  for (const auto& [kind, count] : count_) {
    std::string& text = contains_no_curve(kind) ? notes : warnings;
    text += (text.empty() ? "" : ", ") + std::to_string(count) + " " + kind;
  }
  if (!notes.empty()) drawing.notes.push_back("skipped: " + notes);
  if (!warnings.empty())
    drawing.warnings.push_back("skipped, although they may contain curves: " + warnings);
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
    for (const auto* all : {&drawing.notes, &drawing.warnings})
      for (const std::string& note : *all) notes += " (" + note + ")";
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
