// Writes a shape that changes with a parameter or with time as a series of files.
#pragma once

#include <string>
#include <vector>

#include "batten/apps/commands/runs/run_support.h"
#include "batten/core/isize.h"
#include "batten/io/report/report.h"

namespace batten {

/// Collects the shapes of one series and writes their files.
class ShapeSeries {
 public:
  /// Files are called STEM_000.vtp, …, with digits for `most` shapes. Pictures look like the
  /// scene's first [[picture]]; their captions are LABEL = value.
  ShapeSeries(const Scene& scene, std::string stem, std::string label, const OutputFolder& out,
              int most);

  /// Adds a shape and writes its .vtp at once. Throws InputError.
  void add(Report& report, double value, std::vector<SkinnedRegion> regions);
  int count() const { return isize(files_); }

  /// Writes STEM.pvd, STEM.gif (of 120 shapes at most), and STEM.png with all shapes (48 at most)
  /// or, with `each`, one .png for each shape. All pictures have the same camera and the same
  /// heights of contours. Throws InputError, also when there is no display, after writing STEM.pvd.
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
