#include "batten/io/lines/point_lines.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>
#include <utility>

#include "batten/core/errors.h"
#include "batten/io/files/toml_table.h"
#include "batten/io/lines/point_table.h"
#include "batten/io/lines/segment_chains.h"
#include "batten/io/lines/text_rows.h"
#include "batten/io/lines/unique_names.h"

namespace batten {
namespace fs = std::filesystem;
namespace {

/// Words of an OBJ record, which goes on in the next row after a backslash.
class ObjTokens {
 public:
  explicit ObjTokens(TextRows& rows) : rows_(rows), rest_(without_comment(rows.row())) {}
  /// Empty at the end of the record.
  std::string_view next() {
    for (;;) {
      while (!rest_.empty() && is_blank(rest_.front())) rest_.remove_prefix(1);
      if (rest_ != "\\" || !rows_.next()) break;
      rest_ = without_comment(rows_.row());
    }
    size_t length = 0;
    while (length < rest_.size() && !is_blank(rest_[length]) && rest_.substr(length) != "\\")
      ++length;
    const std::string_view word = rest_.substr(0, length);
    rest_.remove_prefix(length);
    return word;
  }
  std::string_view rest() {
    while (!rest_.empty() && is_blank(rest_.front())) rest_.remove_prefix(1);
    return rest_;
  }

 private:
  TextRows& rows_;
  std::string_view rest_;
};

std::vector<NamedPoints> read_obj(TextRows& rows, double scale) {
  std::vector<NamedPoints> lines;
  std::vector<Vec3> vertices;
  std::string name;
  while (rows.next()) {
    const int line = rows.line();
    ObjTokens words(rows);
    const std::string_view record = words.next();
    const auto end_of_row = [&] { return rows.row().data() + rows.row().size(); };
    if (record == "o" || record == "g") {
      name = words.rest();
    } else if (record == "v") {
      Vec3 point;
      for (int i = 0; i < 3; ++i) {
        const std::string_view word = words.next();
        if (word.empty())
          rows.fail(end_of_row(),
                    "found " + format_count(i, "coordinate") + ", expected 3 (v x y z)");
        point[i] = scale * rows.number_in(word, "a number");
      }
      vertices.push_back(point);
    } else if (record == "l") {
      NamedPoints result{name, {}, line};
      const long count = static_cast<long>(vertices.size());
      for (std::string_view word = words.next(); !word.empty(); word = words.next()) {
        // "vertex/texture": the first number is meant.
        const std::string_view digits = word.substr(0, word.find('/'));
        long index = 0;
        const auto [end, error] =
            std::from_chars(digits.data(), digits.data() + digits.size(), index);
        if (digits.empty() || end != digits.data() + digits.size() || error != std::errc())
          rows.fail(word.data(), "found " + quoted_excerpt(word) + ", expected a vertex number");
        const long vertex = index < 0 ? count + index : index - 1;
        if (index == 0 || vertex < 0 || vertex >= count)
          rows.fail(word.data(), "found vertex number " + std::to_string(index) + ", expected " +
                                     (count ? "1 to " + std::to_string(count) + " or -1 to -" +
                                                  std::to_string(count)
                                            : std::string("vertices (v records) before it")));
        result.points.push_back(vertices[vertex]);
      }
      if (result.points.size() < 2)
        rows.fail(end_of_row(), "found a line of " +
                                    format_count(static_cast<long>(result.points.size()), "point") +
                                    ", expected 2 or more");
      lines.push_back(std::move(result));
    }
  }
  if (!vertices.empty() && lines.empty())
    throw InputError(rows.path().string() + ": found " +
                     format_count(static_cast<long>(vertices.size()), "vertex record") +
                     " but no line, expected records 'l 1 2 3 …'");
  return chain_segments(std::move(lines));
}

/// The count of a row "v N".
long announced_points(const TextRows& rows, std::string_view row) {
  std::vector<std::string_view> words;
  split_fields(row, words);
  if (words[0] != "v")
    rows.fail(words[0].data(), "found " + quoted_excerpt(words[0]) +
                                   ", expected 'v N' before the N points of a line");
  if (words.size() != 2)
    rows.fail(words[0].data(), "found " +
                                   format_count(static_cast<long>(words.size()) - 1, "word") +
                                   " after 'v', expected the number of points");
  long count = 0;
  const char *first = words[1].data(), *last = first + words[1].size();
  const auto [end, error] = std::from_chars(first, last, count);
  if (error != std::errc() || end != last || count < 1)
    rows.fail(first, "found " + quoted_excerpt(words[1]) + ", expected a number of points from 1");
  return count;
}

std::vector<NamedPoints> read_curves(TextRows& rows, double scale) {
  std::vector<NamedPoints> lines;
  std::vector<std::string_view> fields;
  long missing = 0;
  const auto promised = [&] {
    const auto& line = lines.back();
    return format_count(static_cast<long>(line.points.size()), "point") + ", expected " +
           std::to_string(missing + static_cast<long>(line.points.size())) + " as line " +
           std::to_string(line.first_line) + " says";
  };
  while (rows.next()) {
    const std::string_view row = without_comment(rows.row());
    if (row.empty()) continue;
    if (missing == 0) {
      missing = announced_points(rows, row);
      lines.push_back({"", {}, rows.line()});
      continue;
    }
    split_fields(row, fields);
    if (fields[0] == "v") rows.fail(row.data(), "found the next line after " + promised());
    if (fields.size() != 3)
      rows.fail(row.data(), "found " + format_count(static_cast<long>(fields.size()), "number") +
                                ", expected 3 (x y z)");
    Vec3 point;
    for (int i = 0; i < 3; ++i) point[i] = scale * rows.number_in(fields[i], "a number");
    lines.back().points.push_back(point);
    --missing;
  }
  if (missing > 0)
    throw InputError(rows.path().string() + ":" + std::to_string(rows.line()) +
                     ":1: found the end of the file after " + promised());
  return lines;
}

}  // namespace

std::vector<NamedPoints> read_point_lines(const fs::path& path, double scale) {
  if (!(scale > 0) || !std::isfinite(scale))
    throw InputError(path.string() + ": found a unit factor of " + format_number(scale) +
                     ", expected a number above 0");
  const std::string extension = lower_extension(path);
  static const std::vector<std::string> tables{".csv", ".txt", ".xyz", ".dat"};
  const bool obj = extension == ".obj", curves = extension == ".curves";
  if (!obj && !curves && std::find(tables.begin(), tables.end(), extension) == tables.end())
    throw InputError(path.string() + ": found " +
                     (extension.empty() ? "no extension" : "the extension '" + extension + "'") +
                     ", expected .csv, .txt, .xyz, .dat, .obj or .curves");
  TextRows rows(path);
  std::vector<NamedPoints> lines = obj      ? read_obj(rows, scale)
                                   : curves ? read_curves(rows, scale)
                                            : read_point_table(rows, scale);
  if (lines.empty()) throw InputError(path.string() + ":1:1: found no points, expected some");
  std::vector<std::string*> names;
  for (NamedPoints& line : lines) names.push_back(&line.name);
  make_names_unique(names, path.stem().string());
  for (const auto& line : lines)
    for (const Vec3& p : line.points)
      if (!p.allFinite())
        throw InputError(path.string() + ":" + std::to_string(line.first_line) +
                         ":1: numbers of this line are too large for the unit");
  return lines;
}

}  // namespace batten
