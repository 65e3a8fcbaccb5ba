// Reads deforming meshes: numbered files, point caches, animated scenes, results of CalculiX.
#pragma once

#include <filesystem>
#include <string>

#include "batten/core/progress.h"
#include "batten/mesh/sequence/mesh_sequence.h"

namespace batten {

// What the reader of a sequence is told beside its path.

/// How a sequence is read. Frames are counted from 1 in the order of their numbers or times.
struct SequenceOptions {
  /// A mesh file with the faces of a point cache. Empty: the mesh beside it that has its stem, the
  /// first of the numbered files that begin with its stem, or the only mesh of its folder.
  std::filesystem::path mesh;
  /// The first and the last frame that are read; 0 as the last: up to the end. Only these are held
  /// in memory, and of formats that let frames be passed over only these are read.
  int first = 1, last = 0;
  /// Whether numbers may be missing in a run of files.
  bool allow_gaps = false;
  /// glTF: an animation by its name or its number, counted from 1; empty: the first one.
  std::string animation;
  /// glTF: frames a second, from the first key of the animation to its last; 0: a frame at each key.
  double frames_per_second = 24;
  /// glTF: whether vertices that lie at one place in all frames (of the whole animation, up to 1e-6
  /// of the size) are one node: seams of textures and of normals. Else the surface is cut there.
  bool weld_seams = true;
};


/// Reads a deforming mesh. What `path` may be:
///
///   walk_*.obj, walk_%04d.obj    numbered files of any format of MeshFile, in the order of the
///                    numbers, which are the times. A folder stands for the numbered files in it,
///                    any of the files for all that are named as it is but for the last number in
///                    the name. A stride, as 0, 10, 20, is no gap
///   .pvd             ParaView's list of files and times; one part a time
///   .pc2             point cache, POINTCACHE2 version 1; times from its start and rate
///   .mdd             point cache of NewTek; its own times
///   .gltf .glb       glTF 2.0: the scene that is shown first, all triangles in it as one mesh, with
///                    skins, morph targets and moving nodes, baked at times in seconds. Without an
///                    animation it is one frame
///   .frd             results of CalculiX: of each step the displaced nodes; outer faces of solids,
///                    and shells. Nodes are those that these faces have, in the order of their
///                    numbers. Values of steps that do not ascend, as of modes, are counted from 1
///
/// Corners of STL files that lie at one place in the first frame are one node in all of them.
///
/// Throws InputError, which names the file: what MeshFile and check() throw; no such files, several
/// series in a folder, missing numbers (they are named), a frame whose nodes or faces are not those
/// of the first, an STL corner that leaves its node by more than 1e-6 of the size, caches that are
/// cut short or have another number of nodes than the mesh, glTF that is damaged or needs an
/// extension that changes geometry and is unknown, frames that are not there. Throws CancelledError
/// where `progress` asks for it. O(frames · size); memory: the frames, and one file.
MeshSequence read_sequence(const std::filesystem::path& path, const SequenceOptions& options = {},
                           const Progress& progress = {});


// The readers of sequences, one for each kind of file. Internal.

/// Frames that are read, counted from 0.
struct FrameRange {
  int first = 0, count = 0;
  bool has(int frame) const { return frame >= first && frame < first + count; }
};

/// The frames of `all` that the options ask for. Throws InputError when they are not there.
FrameRange frame_range(const SequenceOptions& options, long all, const std::string& name);

/// Points of a frame are one vertex where they lie this near to each other, over the size.
inline constexpr double kWeldTolerance = 1e-6;

using SequenceReader = MeshSequence(const std::filesystem::path&, const SequenceOptions&,
                                    const Progress&);
SequenceReader read_numbered_sequence, read_pvd_sequence, read_pc2_sequence, read_mdd_sequence,
    read_gltf_sequence, read_frd_sequence;

}  // namespace batten
