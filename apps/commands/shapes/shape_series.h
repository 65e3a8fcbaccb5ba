// A shape that changes with a parameter or with time, as files.
#pragma once

#include <string>
#include <vector>

#include "batten/apps/commands/runs/run_parts.h"
#include "batten/core/index.h"
#include "batten/io/report/report.h"

namespace batten {

/// Shapes of one series as they come, written to files in the end.
class ShapeSeries {
 public:
  /// Files are called STEM_000.vtp, …; the look is that of the scene's first [[picture]]; captions
  /// are LABEL = value.
  ShapeSeries(const Scene& scene, std::string stem, std::string label, const OutputFolder& out,
              int most);

  /// Writes the .vtp at once.
  void add(Report& report, double value, std::vector<SkinnedRegion> regions);
  int count() const { return count_of(files_); }

  /// STEM.pvd; with a display STEM.gif (of 120 shapes at most), and STEM.png with all shapes (48 at
  /// most) or (`each`) one .png a shape. All with one camera, and contours at the same heights.
  void finish(Report& report, bool each, const Progress& progress);

 private:
  std::string name(int i, const std::string& ending) const;
  const Scene& scene_;
  std::string stem_, label_;
  const OutputFolder& out_;
  int digits_;
  std::vector<std::pair<double, std::string>> files_;
  std::vector<std::vector<SkinnedRegion>> shapes_;
};

}  // namespace batten
