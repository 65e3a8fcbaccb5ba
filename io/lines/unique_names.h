// Names of lines from files.
#pragma once

#include <string>
#include <vector>

namespace batten {

/// Empty names become `other`; names that are there several times get _1, _2, … in their order.
void make_names_unique(const std::vector<std::string*>& names, const std::string& other);

}  // namespace batten
