// Reads and runs a scene file of any kind.
#pragma once

#include <filesystem>

#include "batten/apps/commands/lines/run_fair.h"
#include "batten/apps/commands/meshes/run_deform.h"
#include "batten/apps/commands/sequences/run_sequence.h"
#include "batten/apps/commands/shapes/run_scene.h"
#include "batten/io/scene/read_scene.h"

namespace batten {

/// Reads a scene file and calls use(scene) with a mutable SequenceScene, DeformScene, FairScene
/// (curves only) or Scene. Throws the exceptions of the reader.
template <class Use>
auto visit_scene(const std::filesystem::path& file, const Use& use) {
  if (is_sequence_scene(file)) {
    SequenceScene scene = read_sequence_scene(file);
    return use(scene);
  }
  if (is_deform_scene(file)) {
    DeformScene scene = read_deform_scene(file);
    return use(scene);
  }
  if (is_fair_scene(file)) {
    FairScene scene = read_fair_scene(file);
    return use(scene);
  }
  Scene scene = read_scene(file);
  return use(scene);
}

/// Runs a scene: writes everything that it requests into the folder `out`. The result is the
/// report.
inline SequenceReport run_any_scene(const SequenceScene& scene, const std::filesystem::path& out,
                                    const Progress& progress) {
  return run_sequence(scene, out, {}, progress);
}
inline DeformReport run_any_scene(const DeformScene& scene, const std::filesystem::path& out,
                                  const Progress& progress) {
  return run_deform(scene, out, progress);
}
inline FairReport run_any_scene(const FairScene& scene, const std::filesystem::path& out,
                                const Progress& progress) {
  return run_fair(scene, out, progress);
}
inline Report run_any_scene(const Scene& scene, const std::filesystem::path& out,
                            const Progress& progress) {
  return run_scene(scene, out, progress);
}

}  // namespace batten
