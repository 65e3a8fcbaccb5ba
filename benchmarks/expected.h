// `batten skin curves.csv` on the shapes that people expect, beside OpenCASCADE.
#pragma once

#include "bench.h"

namespace batten::bench {

/// Prints the table of the 35 expected shapes: distance from the expected surface of Batten's result,
/// of OpenCASCADE's filling of each face that Batten found, and of its lofts. In a build without the
/// commands the table is missing, and so is the promised count.
void compare_expected(Checks& checks);

}  // namespace batten::bench
