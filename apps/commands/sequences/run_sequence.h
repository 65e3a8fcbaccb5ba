// Does the work of `batten sequence`: edits a deforming mesh.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>

#include "batten/core/progress.h"
#include "batten/io/report/sequence_report.h"
#include "batten/io/scene/sequence_scene.h"

namespace batten {

// What a run of `batten sequence` is asked beside its scene.

struct SequenceTask {
  /// Frames that this run makes, counted from 1: so that several runs share the work. None: all.
  std::optional<std::pair<int, int>> frames;

  /// The name of a file that each run of a part has for itself: "walk.png", or "walk_3-7.png".
  std::string name_of(const std::filesystem::path& file) const;
};


/// Does the steps one after the other and writes the frames, report.json and pictures into the
/// folder. Frames in numbered files appear one by one, each whole; where a run of the same scene
/// with the same input was stopped, the next one goes on behind the frames that are there. All other
/// files appear at the end, all of them or none. Throws InputError (a range of frames with output in
/// one file, too), ConflictError, NoSolutionError, CancelledError.
SequenceReport run_sequence(const SequenceScene& scene, const std::filesystem::path& folder,
                            const SequenceTask& task = {}, const Progress& progress = {});

/// The most important results in about a dozen lines, with the files at the end.
std::string summary(const SequenceReport& report, const std::filesystem::path& folder);

}  // namespace batten
