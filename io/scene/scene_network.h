// [network], [[region]] and [[join]]: a scene whose lines are skinned as one network. Internal.
#pragma once

#include "batten/io/scene/scene.h"

namespace batten {

/// Reads them into the scene, whose lines are read already, and refuses, with the reason, what does
/// not go together with a network. Nothing happens without [network]; [[region]] and [[join]] are
/// refused then. Throws InputError.
void read_network(const TomlTable& root, Scene& scene);

}  // namespace batten
