#include "batten/io/lines/drawing_readers.h"

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
  if (!text.empty()) drawing.notes.push_back("passed over: " + text);
}

}  // namespace batten
