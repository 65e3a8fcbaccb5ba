// Writes point caches, PC2 and MDD: all positions of a mesh, frame after frame, in single
// precision.
//
//   PC2  little-endian: "POINTCACHE2\0", int32 version = 1, int32 points, float start, float rate,
//        int32 frames; then x y z of each point, frame after frame
//   MDD  big-endian: int32 frames, int32 points, float time of each frame; then the same
#pragma once

#include <filesystem>
#include <fstream>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/io/files/atomic_file.h"

namespace batten {

/// File formats of point caches.
enum class PointCacheFormat { Pc2, Mdd };

/// Writes a point cache frame by frame. Throws FileError like AtomicFile.
class PointCacheWriter {
 public:
  /// Throws InputError if the times of a PC2 are not evenly spaced.
  PointCacheWriter(const std::filesystem::path& path, PointCacheFormat format, int points,
                   const std::vector<double>& times);
  /// Appends a frame. Throws InputError if a coordinate exceeds single precision.
  void write(const Points& points);
  /// Completes the file and moves it to its final name.
  void finish();

 private:
  AtomicFile file_;
  PointCacheFormat format_;
  std::ofstream out_;
  std::string bytes_;  // buffer for one frame
};

}  // namespace batten
