// Reads deforming meshes: numbered files, point caches, animated glTF scenes, CalculiX results.
#pragma once

#include <filesystem>
#include <string>

#include "batten/core/progress.h"
#include "batten/mesh/sequence/mesh_sequence.h"

namespace batten {

/// Options of read_sequence(). Frames are numbered from 1 in the order of their numbers or times.
struct SequenceOptions {
  /// Mesh file with the faces of a point cache. Empty: the mesh beside the cache with the same
  /// stem, else the first of the numbered files that begin with its stem, else the only mesh of the
  /// folder.
  std::filesystem::path mesh;
  /// First and last frame to read, 1-based; `last` = 0: to the end. Only these frames are held in
  /// memory. Formats with random access read only these frames.
  int first = 1, last = 0;
  /// True: accept missing numbers in a series of files.
  bool allow_gaps = false;
  /// glTF: the animation, by name or by 1-based number; empty: the first one.
  std::string animation;
  /// glTF: frames per second, from the first key of the animation to the last; 0: one frame per
  /// key.
  double frames_per_second = 24;
  /// glTF: true merges vertices that coincide in all frames of the whole animation (within 1e-6 of
  /// the size) into one node, which removes texture and normal seams. False leaves the surface cut
  /// there.
  bool weld_seams = true;
};

/// Reads a deforming mesh from `path`, which may be:
///
///   walk_*.obj, walk_%04d.obj    numbered files of any format of MeshFile, in the order of
///                    their numbers, which are the times. A folder stands for the numbered files
///                    in it. A single file stands for all files whose names differ only in the
///                    last number. A constant stride, such as 0, 10, 20, is no gap
///   .pvd             ParaView's list of files and times; one part per time
///   .pc2             point cache, POINTCACHE2 version 1; times from its start and rate
///   .mdd             NewTek point cache; its own times
///   .gltf .glb       glTF 2.0: all triangles of the default scene as one mesh, with skins, morph
///                    targets and moving nodes, baked at times in seconds. Without an animation
///                    it is one frame
///   .frd             CalculiX results: the displaced nodes of each step, with the outer faces of
///                    solids and with shells. Only nodes of these faces are kept, ordered by
///                    number. Step values that do not ascend, as for modes, are replaced by 1, 2, …
///
/// STL corners that coincide in the first frame are one node in all frames.
///
/// Throws InputError, which names the file, in these cases:
/// - the errors of MeshFile and of MeshSequence's check();
/// - no such files, several series in a folder, or missing numbers (which are listed);
/// - a frame whose nodes or faces differ from those of the first frame;
/// - an STL corner that leaves its node by more than 1e-6 of the size;
/// - a truncated cache, or one whose number of nodes differs from the mesh;
/// - damaged glTF, or glTF that requires an unknown extension that changes geometry;
/// - frames that do not exist.
///
/// Throws CancelledError if `progress` requests it. Cost: O(frames · size); memory: the frames and
/// one file.
MeshSequence read_sequence(const std::filesystem::path& path, const SequenceOptions& options = {},
                           const Progress& progress = {});

// The readers of sequences, one per kind of file.

/// Range of frames to read, 0-based.
struct FrameRange {
  int first = 0, count = 0;
  /// True if the range contains a frame (0-based).
  bool has(int frame) const { return frame >= first && frame < first + count; }
};

/// The frames that the options request, of `all` frames. Throws InputError if they do not exist.
FrameRange frame_range(const SequenceOptions& options, long all, const std::string& name);

/// Tolerance, relative to the size, within which points of a frame are merged into one vertex.
inline constexpr double kWeldTolerance = 1e-6;

/// Signature of the readers.
using SequenceReader = MeshSequence(const std::filesystem::path&, const SequenceOptions&,
                                    const Progress&);
SequenceReader read_numbered_sequence, read_pvd_sequence, read_pc2_sequence, read_mdd_sequence,
    read_gltf_sequence, read_frd_sequence;

}  // namespace batten
