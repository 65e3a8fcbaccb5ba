// What readers of drawings share.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "batten/fairing/curves/primitive_curves.h"
#include "batten/io/lines/drawing.h"

namespace batten {

Drawing read_dxf(const std::filesystem::path& path);
Drawing read_svg(const std::filesystem::path& path);

/// A straight piece.
std::shared_ptr<const InputCurve> straight_segment(const Vec3& a, const Vec3& b);
/// The line at another place.
DrawnLine transformed(const DrawnLine& line, const AffineTransform& transform);

/// What a drawing has and no line comes of: kinds and how many.
class SkippedEntities {
 public:
  void add(const std::string& kind) { ++count_[kind]; }
  /// A sentence, or none.
  void report_to(Drawing& drawing) const;

 private:
  std::map<std::string, int> count_;
};

}  // namespace batten
