// The readers of sequences, one for each kind of file. Internal.
#pragma once

#include <filesystem>
#include <string>

#include "batten/core/progress.h"
#include "batten/io/sequences/sequence_options.h"
#include "batten/mesh/sequence/mesh_sequence.h"

namespace batten {

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
