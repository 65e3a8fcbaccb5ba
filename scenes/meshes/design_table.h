// SPDX-License-Identifier: MPL-2.0
// Designs of experiments: values of parameters for a series of variants.
#pragma once

#include <string>
#include <vector>

#include "batten/scenes/runs/run_support.h"

namespace batten {

/// Parameter values of a series of variants.
struct DesignTable {
  std::vector<std::string> parameters;
  std::vector<std::vector<double>> rows;  ///< per variant, one value for each parameter
};

/// The variants of `--doe TEXT`:
///
///     lhs:N[:SEED]   Latin hypercube of N variants [McKay1979]: every parameter has one value in
///                    each of N equal parts of its range, at random places in random order. Equal
///                    seeds (default 1) give equal values on all machines
///     grid           all combinations of ParameterSweep::count values, equally spaced from end to
///                    end; the last parameter varies fastest
///     FILE           CSV: parameter names in the first row, one variant in each other row. Commas,
///                    semicolons or tabs separate the columns; empty rows and rows that begin with
///                    '#' are skipped
///
/// Throws InputError for invalid text, for ranges that are missing, or not needed, and for more than
/// 100,000 variants.
DesignTable design_table(const std::string& text, const std::vector<ParameterSweep>& ranges);

}  // namespace batten
