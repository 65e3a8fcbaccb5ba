// Display points of a moving surface, and their way to a viewer thread.
#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <vector>

namespace batten {

/// Facets and lines over display points: changes with the mesh only.
struct DisplayPattern {
  std::vector<std::array<int, 3>> facets;
  std::vector<std::vector<std::vector<int>>> lines;  ///< DisplayFacets::lines
};

struct Frame {
  std::vector<float> points, normals;  ///< x, y, z one after the other
  std::shared_ptr<const DisplayPattern> pattern;
  long number = 0;        ///< counts frames
  bool moved = false;     ///< points or normals differ from the frame before
  bool remeshed = false;  ///< so does the pattern
};

/// Three frames between one writer and one reader: neither ever waits, the reader gets the newest
/// whole frame.
class FrameExchange {
 public:
  /// Writer: the frame to fill. Its buffers keep their size from use to use.
  Frame& writing() { return frames_[write_]; }
  /// Writer: hands it over.
  void publish();
  /// Reader: the newest frame, or none when it is the one that latest() gave before. Stays valid
  /// until the next latest().
  const Frame* latest();

 private:
  std::array<Frame, 3> frames_;
  int write_ = 0, read_ = 1;
  std::atomic<int> middle_{2};  // bit 2: not read yet
};

}  // namespace batten
