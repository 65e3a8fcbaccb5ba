// Writes deforming meshes frame by frame.
#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "batten/mesh/shell_mesh.h"

namespace batten {

/// Writes the frames of one mesh as they arrive, without storing them. The path determines the
/// format:
///
///   new/walk_*.obj, new/walk_%04d.ply    numbered files: .obj, .off, .ply, .stl, .vtp, .vtu
///   new              a folder (name without extension), with numbered files frame_*.obj in it
///   .pvd             ParaView's list of files and times, and numbered .vtp files in a folder
///                    beside it with the same stem
///   .pc2 .mdd        point cache in single precision, and the mesh of the first frame as .obj
///                    beside it. PC2 requires evenly spaced times
///   .glb             glTF 2.0 in single precision: the first frame, and each other frame as a
///                    morph target that an animation shows at its time, in seconds
///
/// Files are numbered by the times if all of these are integers from 0 to 999,999, so that a
/// numbered series keeps its numbers; otherwise 1, 2, … Formats without polygons (STL, GLB) get the
/// same triangulation in every frame, computed from the points of `shells`.
///
/// Each numbered file is written atomically with its frame, a single file when everything is
/// complete. The folder of the path is created if it is missing, but not its parents.
class SequenceWriter {
 public:
  /// Throws InputError if frames cannot be written to this path: an unsupported extension, or the
  /// name of a mesh file without a placeholder for a number.
  static void check_name(const std::filesystem::path& path);
  /// Opens the output; only the header of a temporary file may be written. `times`: ascending, one
  /// per frame. Throws InputError for missing or not ascending times, a name rejected by
  /// check_name(), PC2 with uneven times, or a GLB above 4 GB. Also throws the exceptions of
  /// AtomicFile.
  SequenceWriter(const std::filesystem::path& path, const ShellMesh& shells,
                 std::vector<double> times);
  ~SequenceWriter();
  SequenceWriter(const SequenceWriter&) = delete;
  SequenceWriter& operator=(const SequenceWriter&) = delete;

  /// Number of frames.
  int frame_count() const;
  /// The file of a frame (0-based): its numbered file, or the single file.
  std::filesystem::path file(int frame) const;
  /// True if the numbered file of this frame exists, so that an interrupted run can resume without
  /// it. Always false for single files. The caller must make sure that the file belongs to the same
  /// run.
  bool has(int frame) const;
  /// Writes a frame (n×3). Frames must come in ascending order. With numbered files, some may be
  /// omitted until finish(), for example if several processes share the work.
  ///
  /// Throws InputError for a wrong number of points, and for coordinates that are not finite or too
  /// large for the format. Also throws the exceptions of AtomicFile, and std::logic_error for
  /// frames out of order.
  void write(int frame, const Points& points);
  /// Completes the single file, or writes the list of files. Throws std::logic_error if frames are
  /// missing.
  void finish();
  /// All files that exist after finish(), for reports.
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
