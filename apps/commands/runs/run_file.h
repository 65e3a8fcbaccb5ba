// A scene of any kind, by what its file asks for.
#pragma once

#include <filesystem>

#include "batten/apps/commands/lines/run_fair.h"
#include "batten/apps/commands/meshes/run_deform.h"
#include "batten/apps/commands/sequences/run_sequence.h"
#include "batten/apps/commands/shapes/run_scene.h"
#include "batten/io/scene/read_scene.h"

namespace batten {

/// Reads a scene file and calls use(scene) with it: a SequenceScene, a DeformScene, a FairScene (lines
/// alone) or a Scene, which is not constant. Throws what reading throws.
template <class Use>
auto with_scene_of(const std::filesystem::path& file, const Use& use) {
  if (edits_a_sequence(file)) {
    SequenceScene scene = read_sequence_scene(file);
    return use(scene);
  }
  if (edits_a_mesh(file)) {
    DeformScene scene = read_deform_scene(file);
    return use(scene);
  }
  if (only_fairs(file)) {
    FairScene scene = read_fair_scene(file);
    return use(scene);
  }
  Scene scene = read_scene(file);
  return use(scene);
}

/// Does everything that a scene asks for, into a folder: its report.
inline SequenceReport run_any(const SequenceScene& scene, const std::filesystem::path& out,
                              const Progress& progress) {
  return run_sequence(scene, out, {}, progress);
}
inline DeformReport run_any(const DeformScene& scene, const std::filesystem::path& out,
                            const Progress& progress) {
  return run_deform(scene, out, progress);
}
inline FairReport run_any(const FairScene& scene, const std::filesystem::path& out,
                          const Progress& progress) {
  return run_fair(scene, out, progress);
}
inline Report run_any(const Scene& scene, const std::filesystem::path& out,
                      const Progress& progress) {
  return run_scene(scene, out, progress);
}

}  // namespace batten
