// SPDX-License-Identifier: MPL-2.0
#include "batten/scenes/meshes/design_table.h"

#include <algorithm>
#include <boost/tokenizer.hpp>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <random>
#include <sstream>

#include "batten/core/errors.h"
#include "batten/io/files/input_file.h"

namespace batten {
namespace {

constexpr double kMostVariants = 100000;

/// A number in [0, 1), the same on all machines.
double random_number(std::mt19937_64& generator) {
  return static_cast<double>(generator() >> 11) * 0x1p-53;
}

std::vector<std::vector<double>> latin_hypercube(const std::vector<ParameterSweep>& ranges,
                                                 size_t count, std::uint64_t seed) {
  std::mt19937_64 generator(seed);
  std::vector<std::vector<double>> rows(count, std::vector<double>(ranges.size()));
  std::vector<size_t> order(count);
  for (size_t p = 0; p < ranges.size(); ++p) {
    std::iota(order.begin(), order.end(), size_t{0});
    for (size_t i = count; i > 1; --i)
      std::swap(order[i - 1], order[static_cast<size_t>(random_number(generator) * i)]);
    for (size_t i = 0; i < count; ++i) {
      const double place =
          (static_cast<double>(order[i]) + random_number(generator)) / static_cast<double>(count);
      rows[i][p] = ranges[p].from + place * (ranges[p].to - ranges[p].from);
    }
  }
  return rows;
}

std::vector<std::vector<double>> full_grid(const std::vector<ParameterSweep>& ranges,
                                           const std::string& where) {
  double count = 1;
  for (const ParameterSweep& range : ranges) count *= range.count;
  if (count > kMostVariants)
    throw InputError(where + "found " + format_number(count) + " variants, expected at most " +
                     format_number(kMostVariants));
  std::vector<std::vector<double>> rows{{}};
  for (const ParameterSweep& range : ranges) {
    std::vector<std::vector<double>> longer;
    for (const auto& row : rows)
      for (int i = 0; i < range.count; ++i) {
        longer.push_back(row);
        longer.back().push_back(range.at(i));
      }
    rows = std::move(longer);
  }
  return rows;
}

std::vector<std::string> cells_of(const std::string& line, const std::string& where) {
  std::vector<std::string> cells;
  try {
    const boost::escaped_list_separator<char> separator("\\", ",;\t", "\"");
    const boost::tokenizer<boost::escaped_list_separator<char>> words(line, separator);
    for (const std::string& cell : words) {
      const auto first = cell.find_first_not_of(" \r");
      cells.push_back(first == std::string::npos
                          ? ""
                          : cell.substr(first, cell.find_last_not_of(" \r") - first + 1));
    }
  } catch (const boost::escaped_list_error& e) {
    throw InputError(where + e.what());
  }
  return cells;
}

DesignTable read_table(const std::string& file) {
  std::istringstream text(read_input_file(file, "a table of parameter values (.csv)"));
  DesignTable table;
  std::string line;
  for (int number = 1; std::getline(text, line); ++number) {
    if (number == 1 && line.starts_with("\xef\xbb\xbf")) line.erase(0, 3);
    if (line.starts_with("#") || line.find_first_not_of(" \t\r,;") == std::string::npos) continue;
    const std::string where = file + ":" + std::to_string(number) + ": ";
    const std::vector<std::string> cells = cells_of(line, where);
    if (table.parameters.empty()) {
      table.parameters = cells;
      continue;
    }
    if (cells.size() != table.parameters.size())
      throw InputError(where + "found " + std::to_string(cells.size()) + " columns, expected " +
                       std::to_string(table.parameters.size()) + ", as in the first row");
    table.rows.emplace_back();
    for (const std::string& cell : cells) {
      const std::optional<double> value = parse_number(cell);
      if (!value) throw InputError(where + "found '" + cell + "', expected a number");
      table.rows.back().push_back(*value);
    }
  }
  if (table.rows.empty())
    throw InputError(file +
                     ": found no variants, expected parameter names in the first row and one "
                     "variant in each other row");
  if (static_cast<double>(table.rows.size()) > kMostVariants)
    throw InputError(file + ": found " + std::to_string(table.rows.size()) +
                     " variants, expected at most " + format_number(kMostVariants));
  return table;
}

/// The numbers of "lhs:N[:SEED]".
std::pair<size_t, std::uint64_t> parse_latin_hypercube(const std::string& text,
                                                       const std::string& where) {
  const size_t colon = text.find(':', 4);
  const auto count = parse_number(text.substr(4, colon == std::string::npos ? colon : colon - 4)),
             seed = colon == std::string::npos ? std::optional(1.0)
                                               : parse_number(text.substr(colon + 1));
  const auto whole = [](const std::optional<double>& n, double least, double most) {
    return n && *n == std::floor(*n) && *n >= least && *n <= most;
  };
  if (!whole(count, 1, kMostVariants) || !whole(seed, 0, 1e15))
    throw InputError(where + "found '" + text +
                     "', expected lhs:N or lhs:N:SEED with whole numbers, N from 1 to " +
                     format_number(kMostVariants));
  return {static_cast<size_t>(*count), static_cast<std::uint64_t>(*seed)};
}

}  // namespace

DesignTable design_table(const std::string& text, const std::vector<ParameterSweep>& ranges) {
  const std::string where = "--doe " + text + ": ";
  const bool hypercube = text.starts_with("lhs:");
  if (!hypercube && text != "grid") {
    if (!text.ends_with(".csv") && !text.ends_with(".txt") && !text.ends_with(".tsv"))
      throw InputError(where + "found '" + text +
                       "', expected lhs:N, grid, or a table (.csv, .txt, .tsv)");
    return read_table(text);
  }
  if (ranges.empty())
    throw InputError(where + "found no ranges of parameters, expected --range NAME=FROM:TO");
  DesignTable table;
  for (const ParameterSweep& range : ranges) table.parameters.push_back(range.parameter);
  if (hypercube) {
    const auto [count, seed] = parse_latin_hypercube(text, where);
    table.rows = latin_hypercube(ranges, count, seed);
  } else {
    table.rows = full_grid(ranges, where);
  }
  return table;
}

}  // namespace batten
