// Reads curves that are given by points from text files.
#pragma once

#include <filesystem>
#include <vector>

#include "batten/io/lines/named_lines.h"

namespace batten {

/// Reads the curves of a file. The extension selects the format:
///
///   .csv .txt .xyz .dat   One point per row: 2 or 3 numbers separated by commas, semicolons, tabs
///                         or blanks (2: z = 0). If the numbers are separated by semicolons, tabs
///                         or blanks, a comma inside a number is a decimal comma. '#' and '//'
///                         start comments. Rows of words before the numbers are titles, also if
///                         they contain digits. A header that names x, y, z (at least two of them)
///                         selects the columns; others are skipped. A column "line", "name" or
///                         "curve" assigns each point to a curve. Without a header, the first of
///                         four columns may be the index of the point. Blank rows, or rows of
///                         separators only, separate curves; a row of words after them names the
///                         next curve. Names: the file name, with _1, _2, … if there are several
///                         curves. A row `CURVE 3` also starts a curve and names it "curve 3".
///                         Offset tables (OffsetTable) give one curve per station, Lednicer
///                         airfoils (join_lednicer) one curve around both sides.
///   .obj                  `v` and `l` records, indices from 1 or negative (from the end). Each `l`
///                         record is one curve, named after the last `o` or `g` record before it
///                         (numbered if several have the same name), else after the file. Records
///                         of two vertices are chained into curves (chain_segments()). All other
///                         records are skipped.
///   .curves               Drawn strokes: a row `v N`, then N rows of three numbers, and so on;
///                         blank rows and comments in between are skipped. Names as for .csv. A
///                         stroke may be a single point, because drawn sketches contain such
///                         strokes.
///
/// Repeated points are kept. A UTF-8 byte-order mark and CRLF line ends are accepted.
/// `file_unit_over_model_unit` multiplies all coordinates. Reads about 3 million points per second;
/// the whole file is held in memory. Throws InputError, "file:line:column: found X, expected Y":
/// also for an unknown extension, a missing file, a file without points, a curve of one point
/// (except in .curves), non-finite numbers, and a unit factor that is not above 0.
std::vector<NamedPoints> read_point_lines(const std::filesystem::path& path,
                                          double file_unit_over_model_unit = 1);

}  // namespace batten
