// SPDX-License-Identifier: MPL-2.0
// Reads deforming meshes from numbered files, point caches, animated glTF scenes and CalculiX
// results.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "batten/core/progress.h"
#include "batten/mesh/sequence/mesh_sequence.h"

namespace batten {

/// Options of read_frames(). Frames are numbered from 1, in the order of the numbers or times of
/// the files.
struct SequenceOptions {
  /// Mesh file that contains the faces of a point cache. Empty: a mesh next to the cache with the
  /// same stem, else the first of the numbered files whose names begin with this stem, else the
  /// only mesh in the folder.
  std::filesystem::path mesh;
  /// First and last frame to read, 1-based; `last` = 0: up to the end of the sequence. Only these
  /// frames are held in memory; formats with random access read only these frames.
  int first = 1, last = 0;
  /// True: file numbers may be missing in a series of numbered files. False: gaps are an error.
  bool allow_gaps = false;
  /// glTF: name or 1-based number of the animation; empty: the first animation.
  std::string animation;
  /// glTF: sampling rate between the first and last key of the animation, frames per second; 0: one
  /// frame per key.
  double frames_per_second = 24;
  /// glTF. True: vertices that coincide in all frames of the animation (within 1e-6 of the size)
  /// become one node, which removes texture and normal seams. False: the mesh stays cut along the
  /// seams.
  bool weld_seams = true;
};

/// Reads a deforming mesh. `path` has one of the following forms:
///
///   walk_*.obj, walk_%04d.obj    numbered files in any format of MeshFile, in the order of their
///                    numbers, which are also the times. A folder stands for the numbered files
///                    in it. A single file stands for all files whose names differ only in the
///                    last number. A constant stride, such as 0, 10, 20, is not a gap.
///   .pvd             ParaView's list of files and times, with one part per time
///   .pc2             point cache, POINTCACHE2 version 1; times follow from its start and rate
///   .mdd             NewTek point cache, which contains times
///   .gltf .glb       glTF 2.0: all triangles of the default scene as one mesh, with skins, morph
///                    targets and moving nodes, sampled at times in seconds. A file without an
///                    animation has one frame.
///   .frd             CalculiX results: the displaced nodes of each step, with the outer faces of
///                    solids and with shells. Only nodes of these faces are kept, ordered by
///                    number. Step values that do not increase, as for modes, are replaced by 1,
///                    2, …
///
/// STL corners that coincide in the first frame become one node in all frames.
///
/// Throws InputError, with the name of the file, if:
/// - MeshFile::read() or the check() of MeshSequence fails;
/// - there are no such files, several series in a folder, or missing numbers (which are listed);
/// - the nodes or faces of a frame differ from those of the first frame;
/// - an STL corner moves away from its node by more than 1e-6 of the size;
/// - a cache is truncated, or its number of nodes differs from the mesh;
/// - glTF data is damaged, or requires an unknown extension that changes the geometry;
/// - the requested frames do not exist.
///
/// Throws CancelledError if `progress` requests cancellation. Cost: O(frames · size). Memory: the
/// frames and one file.
MeshSequence read_frames(const std::filesystem::path& path, const SequenceOptions& options = {},
                         const Progress& progress = {});

// Readers of sequences, one per file format.

/// A range of `count` frames of a sequence, from the 0-based frame `first` on.
struct FrameRange {
  int first = 0, count = 0;
  /// True if the range of frames contains `frame` (0-based).
  bool has(int frame) const { return frame >= first && frame < first + count; }
};

/// The range of frames that the options request from a sequence of `all` frames. `name`: name of
/// the sequence for messages. Throws InputError if a requested frame does not exist.
FrameRange frame_range(const SequenceOptions& options, long all, const std::string& name);

/// Throws MemoryError if `frames` frames of `points` points do not fit into the available memory.
void require_frame_memory(const std::filesystem::path& file, long frames, long points);

/// Tolerance within which points of a frame are merged into one vertex, relative to the size of the
/// mesh.
inline constexpr double kWeldTolerance = 1e-6;

/// Function type of the sequence readers, one per file format; parameters as in read_frames().
using SequenceReader = MeshSequence(const std::filesystem::path&, const SequenceOptions&,
                                    const Progress&);
SequenceReader read_numbered_sequence, read_pvd_sequence, read_pc2_sequence, read_mdd_sequence,
    read_gltf_sequence, read_frd_sequence;

// Names and series of numbered files such as walk_0001.obj.

/// A file name with a placeholder for a number: "walk_*.obj", "walk_%04d.obj".
struct NumberedName {
  std::filesystem::path folder;
  std::string prefix, suffix;  ///< parts of the file name before and after the number
  int digits = 1;              ///< minimum number of digits; zeros are added to shorter numbers

  /// The path with the placeholder * in place of the number, such as "out/walk_*.obj".
  std::string pattern() const;
  /// The path of the numbered file with the given number.
  std::filesystem::path file(long number) const;
  /// The number in a file name; empty if the name is not prefix, number and suffix.
  std::optional<long> number_of(const std::string& file_name) const;
};

/// Parses a path that contains a placeholder for a number: *, %d, %4d or %04d. Empty if the path
/// contains no placeholder. When files are written, * stands for at least four digits. Throws
/// InputError if there are several placeholders, a placeholder in the folder, or an invalid %.
std::optional<NumberedName> pattern_of(const std::filesystem::path& path);

/// One file of a series of numbered files.
struct NumberedFile {
  std::filesystem::path path;
  long number = 0;
};

/// The files of a series of numbered files, in ascending order of the numbers. `path`: a pattern, a
/// folder that contains a single series of mesh files, or any file of the series. A file without a
/// number in its name is a series of one file. Sets `name` to the name of the series, for messages.
/// Throws InputError if there are no such files, several series, or a number that occurs twice.
std::vector<NumberedFile> numbered_files(const std::filesystem::path& path, std::string& name);

/// Throws InputError if a series of numbered files with constant stride has gaps; the message lists
/// the missing numbers. `name`: name of the series for the message.
void require_no_gaps(const std::vector<NumberedFile>& files, const std::string& name);

}  // namespace batten
