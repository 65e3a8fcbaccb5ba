// What in a scene's text decides what: whether an edit needs a new model, a new session, or values only.
#pragma once

#include <map>
#include <string>

#include "batten/io/scene/scene_text.h"

namespace batten {

/// The parts of a scene's text that decide what is made of it, without comments and layout.
struct SceneDependencies {
  /// Lines, network and skin: two texts with the same `model` have the same model.
  std::string model;
  /// The same without [skin].
  std::string lines;
  /// Each load, weight, move, constraint and [[parameter]] by "KIND NAME", without its value: two
  /// texts with the same `session_parts` differ in values of live parameters at most.
  std::map<std::string, std::string> session_parts;
};

/// The parts of a scene. alpha and beta are values where they are numbers. O(bytes).
SceneDependencies scene_dependencies(const SceneText& scene);

}  // namespace batten
