// Reads tables of points: a point a row, offset tables, airfoils.
#pragma once

#include <vector>

#include "batten/io/lines/named_points.h"
#include "batten/io/lines/text_rows.h"

namespace batten {

/// The lines of a table, as read_point_lines() says for .csv, .txt, .xyz and .dat; those without a
/// name of their own have none yet. Throws InputError.
std::vector<NamedPoints> read_point_table(TextRows& rows, double scale);

}  // namespace batten
