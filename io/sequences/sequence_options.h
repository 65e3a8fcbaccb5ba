// What the reader of a sequence is told beside its path.
#pragma once

#include <filesystem>
#include <string>

namespace batten {

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

}  // namespace batten
