#include "batten/io/lines/drawing_parts.h"

namespace batten {

std::shared_ptr<const InputCurve> straight(const Vec3& a, const Vec3& b) {
  return bezier_curve(a, a + (b - a) / 3, b - (b - a) / 3, b);
}

DrawnLine placed(const DrawnLine& line, const Placement& placement) {
  DrawnLine result = line;
  for (Vec3& p : result.points) p = placement(p);
  if (line.curve) result.curve = placed(line.curve, placement);
  return result;
}

void PassedOver::say_in(Drawing& drawing) const {
  std::string text;
  for (const auto& [kind, count] : count_)
    text += (text.empty() ? "" : ", ") + std::to_string(count) + " " + kind;
  if (!text.empty()) drawing.notes.push_back("passed over: " + text);
}

}  // namespace batten
