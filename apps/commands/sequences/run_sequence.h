// Implements `batten sequence`: edits a mesh sequence.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>

#include "batten/core/progress.h"
#include "batten/io/report/sequence_report.h"
#include "batten/io/scene/sequence_scene.h"

namespace batten {

/// Options of a run, beside its scene.
struct SequenceTask {
  /// Range of frames to compute (1-based, inclusive), so that several runs can share the work.
  /// Empty: all frames.
  std::optional<std::pair<int, int>> frames;

  /// Name of an output file that is separate for each partial run: "walk.png", or "walk_3-7.png".
  std::string name_of(const std::filesystem::path& file) const;
};

/// Performs the steps in order, and writes the frames, report.json and pictures into the folder.
///
/// Numbered frame files appear one by one, each written atomically. A run that was interrupted
/// resumes after its existing frames, if scene and input are unchanged. All other files appear at
/// the end, all or none. Throws InputError (also for a range of frames with output to a single
/// file), ConflictError, NoSolutionError, CancelledError.
SequenceReport run_sequence(const SequenceScene& scene, const std::filesystem::path& folder,
                            const SequenceTask& task = {}, const Progress& progress = {});

/// A summary of the most important results in about a dozen lines, followed by the files.
std::string summary(const SequenceReport& report, const std::filesystem::path& folder);

}  // namespace batten
