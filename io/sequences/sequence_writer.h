// Writes deforming meshes frame by frame.
#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "batten/mesh/shell_mesh.h"

namespace batten {

/// Writes the frames of one mesh as they come; none is kept. The path says the format:
///
///   new/walk_*.obj, new/walk_%04d.ply    numbered files: .obj, .off, .ply, .stl, .vtp, .vtu
///   new              a folder, numbered frame_*.obj in it (a name without an extension)
///   .pvd             numbered .vtp in a folder beside it that has its stem, and ParaView's list of
///                    them with their times
///   .pc2 .mdd        point caches in single precision, and the mesh in its first frame as .obj
///                    beside it. PC2 has evenly spaced times only
///   .glb             glTF 2.0: the first frame, and each other one as a morph target that an
///                    animation shows at its time, in seconds; in single precision
///
/// The numbers of files are the times where all of these are whole numbers from 0 to 999,999, so
/// that files that were read numbered keep their numbers; else 1, 2, … Formats without polygons
/// (STL, GLB) get the same triangles in every frame, those of the shells' points.
///
/// Each numbered file appears whole or not at all when its frame is written, a single file when
/// everything is. The folder of the path is made where it is missing, but none above it.
class SequenceWriter {
 public:
  /// Whether frames can be written to files of this name. Throws InputError: an extension that is
  /// none of the above, a mesh file's name without a place for a number.
  static void check_name(const std::filesystem::path& path);
  /// Nothing is written yet, except the head of a temporary file. `times` has one for each frame,
  /// ascending. Throws InputError: no times, times that do not ascend, a name that check_name refuses,
  /// PC2 with uneven times, a GLB above 4 GB; what AtomicFile throws.
  SequenceWriter(const std::filesystem::path& path, const ShellMesh& shells,
                 std::vector<double> times);
  ~SequenceWriter();
  SequenceWriter(const SequenceWriter&) = delete;
  SequenceWriter& operator=(const SequenceWriter&) = delete;

  int frame_count() const;
  /// The file of a frame, counted from 0: its numbered file, or the one file of all.
  std::filesystem::path file(int frame) const;
  /// Whether this frame needs no write(): its numbered file is there. A run that was stopped goes on
  /// by passing over these. Never in single files. It is for the caller to know that the file is of
  /// the same run.
  bool has(int frame) const;
  /// Writes a frame (n×3). Frames come in ascending order; of numbered files some may be left out
  /// until finish(), as where several runs share the work.
  /// Throws InputError: another number of points, a coordinate that is not finite or too large for
  /// the format, what AtomicFile throws. Throws std::logic_error for frames in another order.
  void write(int frame, const Points& points);
  /// Ends the file, or writes the list of files. Throws std::logic_error while frames are missing.
  void finish();
  /// What stands on the disk after finish(), for reports.
  std::vector<std::filesystem::path> files() const;

 private:
  class Output;
  class Numbered;
  class Cache;
  class Glb;
  std::unique_ptr<Output> output_;
  int next_ = 0;
};

}  // namespace batten
