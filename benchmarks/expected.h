// SPDX-License-Identifier: MPL-2.0
// `batten skin curves.csv` on the expected shapes, compared with OpenCASCADE.
#pragma once

#include "bench.h"

namespace batten::bench {

/// Prints the table of the 35 expected shapes: distance from the expected surface of Batten's
/// result, of OpenCASCADE's filling of each face that Batten found, and of its lofts. In a build
/// without the commands there is no table, and the check of the count fails.
void compare_expected(Checks& checks);

}  // namespace batten::bench
