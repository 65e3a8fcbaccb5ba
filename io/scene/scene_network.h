// Reads [network], [[region]] and [[join]] of a scene, whose lines are one network. Internal.
#pragma once

#include "batten/io/scene/scene.h"

namespace batten {

/// Reads these tables into the scene, whose lines have been read before. Without [network] it
/// changes nothing. Throws InputError: a mistake in the tables, what cannot stand beside [network],
/// a [[region]] or [[join]] without it.
void read_network(const TomlTable& root, Scene& scene);

}  // namespace batten
