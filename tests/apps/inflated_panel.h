// SPDX-License-Identifier: MPL-2.0
// A scene for tests of documents.
#pragma once

#include <string>

namespace batten_test {

inline const std::string kInflatedPanel = R"(# A panel that swells.
unit = "mm"
[[curve]]
name = "rim"
points = [[0,0,0], [400,0,0], [400,300,0], [0,300,0], [0,0,0]]

[mesh]
edge_length = 40

[[load]]
name = "crown"
type = "pressure"
value = 3
)";

}  // namespace batten_test
