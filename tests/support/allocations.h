// SPDX-License-Identifier: MPL-2.0
// Counts allocations as Work::Allocation. Linking this file replaces malloc if possible, i.e. with
// glibc and without sanitizers.
#pragma once

#include "batten/core/op_counter.h"

namespace batten_test {

/// Whether this program counts calls of malloc and related functions.
bool counts_allocations();

}  // namespace batten_test
