// Reads deforming meshes: numbered files, point caches, animated scenes, results of CalculiX.
#pragma once

#include <filesystem>

#include "batten/core/progress.h"
#include "batten/io/sequences/sequence_options.h"
#include "batten/mesh/sequence/mesh_sequence.h"

namespace batten {

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

}  // namespace batten
