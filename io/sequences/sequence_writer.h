// SPDX-License-Identifier: MPL-2.0
// Writes deforming meshes frame by frame.
#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "batten/mesh/shell_mesh.h"

namespace batten {

/// Writes the frames of a deforming mesh one by one, without storing them. The path determines the
/// format:
///
///   new/walk_*.obj, new/walk_%04d.ply    numbered files: .obj, .off, .ply, .stl, .vtp, .vtu
///   new              a folder (a name without extension) with numbered files frame_*.obj
///   .pvd             ParaView's list of files and times, and numbered .vtp files in a folder next
///                    to it with the same stem
///   .pc2 .mdd        point cache in single precision, and the mesh of the first frame as an .obj
///                    file next to it. PC2 requires evenly spaced times.
///   .glb             glTF 2.0 in single precision: the first frame as the mesh, and every other
///                    frame as a morph target, shown by an animation at its time in seconds
///
/// If all times are integers from 0 to 999,999, files are numbered by their times, so that a
/// numbered series keeps its numbers; otherwise files are numbered 1, 2, … In formats without
/// polygons (STL, GLB) all frames have the same triangulation, computed from `shells.points`.
///
/// Each numbered file is written atomically by write(), a single file by finish(). The folder of
/// the path is created if it is missing, but its parent folders are not.
class SequenceWriter {
 public:
  /// Throws InputError if a sequence cannot be written to `path`, because the extension is not
  /// supported or the name of a mesh file has no placeholder for a number.
  static void check_name(const std::filesystem::path& path);
  /// Opens an output for frames of the mesh `shells`. At most the header of a temporary file is
  /// written. `times`: one time per frame, ascending. Throws InputError if times are missing or not
  /// ascending, check_name() rejects the path, the times of a PC2 file are uneven, or a GLB file
  /// would exceed 4 GB. Throws FileError if a file cannot be created.
  SequenceWriter(const std::filesystem::path& path, const ShellMesh& shells,
                 std::vector<double> times);
  ~SequenceWriter();
  SequenceWriter(const SequenceWriter&) = delete;
  SequenceWriter& operator=(const SequenceWriter&) = delete;

  /// Number of frames of the sequence, equal to the number of times passed to the constructor.
  int frame_count() const;
  /// The file of a frame (0-based): its numbered file, or the single file of the sequence.
  std::filesystem::path file(int frame) const;
  /// True if the numbered file of a frame exists, so that an interrupted run can skip this frame.
  /// Always false for formats with a single file. The caller must make sure that the existing file
  /// belongs to the same run.
  bool has(int frame) const;
  /// Writes a frame (0-based), given by its n×3 node positions. Frames must be written in ascending
  /// order. Numbered files may be omitted, for example if several processes share the work; all
  /// must exist when finish() is called.
  ///
  /// Throws InputError for a wrong number of points, and for coordinates that are not finite or too
  /// large for the format. Throws FileError if a file cannot be written, and std::logic_error for
  /// frames that are out of order.
  void write(int frame, const Points& points);
  /// Completes the output: finishes the single file of the sequence, or writes the list of files
  /// (.pvd). Throws std::logic_error if frames are missing.
  void finish();
  /// All output files that exist after finish(), for example for reports.
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
