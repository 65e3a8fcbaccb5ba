// Makes Work::Allocation count: linked in, this replaces malloc where that is possible, which is
// with glibc and without sanitizers.
#pragma once

#include "batten/core/op_counter.h"

namespace batten_test {

/// Whether calls of malloc and its kin are counted in this program.
bool counts_allocations();

}  // namespace batten_test
