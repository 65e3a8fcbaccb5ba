// The motions that supports leave to a shell. Internal.
#pragma once

#include <string>
#include <vector>

#include "batten/analysis/models/shell_ties.h"

namespace batten {

// Motions in which each region stays rigid and no row and no spring resists, in words: "all of it can
// slide along [0, 0, 1]", "region 'lid' can turn about the axis along … through …". None where the
// shell is held. A motion that is resisted by less than 1e-5 of what others are counts as free.
// O(rows + (6 regions)³); models of more than 500 regions are looked at as one body.
std::vector<std::string> free_motions(const ModelLayout& model, const Points& shape,
                                      const ShellTies& ties);

}  // namespace batten
