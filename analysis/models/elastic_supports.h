// Springs of ElasticSupport. Internal.
#pragma once

#include "batten/analysis/models/shell_definition.h"

namespace batten {

// Throws InputError: no such line or region, stiffness below 0 or none.
void add_elastic_support(const ModelLayout& model, const Points& shape,
                         const ElasticSupport& support, ShellSprings& springs);

}  // namespace batten
