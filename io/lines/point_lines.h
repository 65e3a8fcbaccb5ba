// Reads lines that are given as points in text files.
#pragma once

#include <filesystem>
#include <vector>

#include "batten/io/lines/named_lines.h"

namespace batten {

/// Reads the lines of a file. Its extension says the format.
///
///   .csv .txt .xyz .dat   One point a row, 2 or 3 numbers with commas, semicolons, tabs or blanks
///                         between them (2: z = 0). Commas inside numbers are decimal ones where
///                         semicolons, tabs or blanks are between the numbers. '#' and '//' start
///                         comments. Rows of words before the numbers are titles, digits in them or
///                         not. A header that names x, y, z (two of them at least) says which
///                         columns are meant, others are passed over; a column "line", "name" or
///                         "curve" says which line a point is of. Of four columns without a header
///                         the first may count the points. Blank rows, or rows of separators only,
///                         separate lines; a row of words after them names the next. Names: the
///                         file's name, with _1, _2, … when there are several lines. A row
///                         `CURVE 3` begins a line too, and names it "curve 3".
///                         Offset tables (OffsetTable) give a line for each station, Lednicer's
///                         airfoils (join_lednicer) one line around both sides.
///   .obj                  `v` and `l` records, indices from 1 or negative (from the end); each `l`
///                         record is one line, named after the last `o` or `g` record before it
///                         (numbered when several share the name), else after the file. Records of
///                         two vertices are chained into lines (chain_segments()). Everything else
///                         in the file is passed over.
///   .curves               Drawn strokes: a row `v N`, then N rows of three numbers, and so on;
///                         blank rows and comments between are passed over. Names are made as for
///                         .csv. A stroke may be a single point, because drawn sketches have some.
///
/// Points that repeat the one before them are kept. A UTF-8 byte-order mark and CRLF line ends are
/// accepted. `file_unit_over_model_unit` multiplies all numbers. Reads about 3 million points a
/// second, with the whole file in memory.
/// Throws InputError, "file:line:column: found X, expected Y": also for another extension, a file
/// that is missing or without points, a line of one point (not in .curves), numbers that are not
/// finite, a unit factor not above 0.
std::vector<NamedPoints> read_point_lines(const std::filesystem::path& path,
                                          double file_unit_over_model_unit = 1);

}  // namespace batten
