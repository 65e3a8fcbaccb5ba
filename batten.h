// SPDX-License-Identifier: MPL-2.0
// The programming interface of Batten: models, sessions, meshes and their deformers in one header.
//
//     #include <batten/batten.h>
//
//     const batten::Model model = batten::skin({{"front", {{0, 0, 0}, {1, 0, 0}}}, …});
//     model.save("panel.step");
//
// find_package(batten REQUIRED COMPONENTS scenes); target_link_libraries(… batten::scenes)
//
// The kernel behind it (elements, constraints, deformers) has headers of its own, by folder, and
// needs none of the libraries for files: batten::kernel, batten::mesh (docs/architecture.md).
#pragma once

#include "batten/core/errors.h"
#include "batten/core/log.h"
#include "batten/core/parallel.h"
#include "batten/core/progress.h"
#include "batten/scenes/fit_surface.h"
#include "batten/scenes/mesh.h"
#include "batten/scenes/model.h"
#include "batten/scenes/sequence.h"
#include "batten/scenes/session.h"
#include "batten/scenes/stress.h"
