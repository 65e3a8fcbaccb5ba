// Shared helpers of the DXF and SVG readers.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "batten/fairing/curves/primitive_curves.h"
#include "batten/io/lines/drawing.h"

namespace batten {

/// The format-specific parts of read_drawing().
Drawing read_dxf(const std::filesystem::path& path);
Drawing read_svg(const std::filesystem::path& path);

/// A straight line from `a` to `b`, as a cubic.
std::shared_ptr<const InputCurve> straight_segment(const Vec3& a, const Vec3& b);
/// The curve under an affine transformation.
DrawnLine transformed(const DrawnLine& line, const AffineTransform& transform);

/// Counts entities that cannot be converted to curves, by kind.
class SkippedEntities {
 public:
  void add(const std::string& kind) { ++count_[kind]; }
  /// Adds a sentence that lists them to the notes of a drawing; nothing if there are none.
  void report_to(Drawing& drawing) const;

 private:
  std::map<std::string, int> count_;
};

}  // namespace batten
