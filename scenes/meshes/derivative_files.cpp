// SPDX-License-Identifier: MPL-2.0
#include "batten/scenes/meshes/derivative_files.h"

#include <algorithm>
#include <array>
#include <charconv>

#include "batten/core/errors.h"
#include "batten/io/files/atomic_file.h"
#include "batten/io/files/npz_file.h"
#include "batten/io/files/text.h"

namespace batten {
namespace {

bool is_nastran_extension(const std::string& extension) {
  constexpr std::array<const char*, 4> known = {".bdf", ".nas", ".dat", ".fem"};
  return std::find(known.begin(), known.end(), extension) != known.end();
}

/// The fewest digits that read back exactly.
void append_number(std::string& text, double value) {
  std::array<char, 32> digits;
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr;
  text.append(digits.data(), end);
}

void write_csv(std::ostream& out, const DerivativeTable& table) {
  std::string text = "node,x,y,z";
  for (const MorphDerivative& d : *table.derivatives)
    for (const char* axis : {"dx", "dy", "dz"})
      text += "," + csv_cell(d.parameter.name + ":" + axis);
  text += "\n";
  for (long v = 0; v < table.file->shells().node_count(); ++v) {
    text += std::to_string(table.file->node_label(static_cast<int>(v)));
    const auto append_row = [&](const Points& rows) {
      for (int k = 0; k < 3; ++k) append_number(text += ",", rows(v, k));
    };
    append_row(*table.points);
    for (const MorphDerivative& d : *table.derivatives) append_row(d.rate);
    text += "\n";
    out << text;
    text.clear();
  }
}

void append_rows(std::vector<double>& values, const Points& rows, long count) {
  for (long v = 0; v < count; ++v)
    for (int k = 0; k < 3; ++k) values.push_back(rows(v, k));
}

void write_npz(const std::filesystem::path& path, const DerivativeTable& table) {
  const auto& derivatives = *table.derivatives;
  const long nodes = table.file->shells().node_count();
  std::vector<std::string> names, dimension_names;
  std::vector<double> values, rates, points, dimension_values, dimension_rates;
  std::vector<std::int64_t> labels;
  for (long v = 0; v < nodes; ++v) labels.push_back(table.file->node_label(static_cast<int>(v)));
  append_rows(points, *table.points, nodes);
  for (const MorphDerivative& d : derivatives) {
    names.push_back(d.parameter.name);
    values.push_back(d.parameter.value);
    append_rows(rates, d.rate, nodes);
  }
  for (size_t k = 0; k < table.dimensions->size(); ++k) {
    dimension_names.push_back((*table.dimensions)[k].name());
    dimension_values.push_back((*table.dimensions)[k].value(*table.points));
    for (const MorphDerivative& d : derivatives) dimension_rates.push_back(d.dimensions[k]);
  }
  NpzFile npz;
  const auto n = static_cast<size_t>(nodes);
  npz.add("parameters", names);
  npz.add("values", {values.size()}, values);
  npz.add("nodes", labels);
  npz.add("points", {n, 3}, points);
  npz.add("derivatives", {derivatives.size(), n, 3}, rates);
  npz.add("dimensions", dimension_names);
  npz.add("dimension_values", {dimension_values.size()}, dimension_values);
  npz.add("dimension_derivatives", {dimension_names.size(), derivatives.size()}, dimension_rates);
  npz.write(path);
}

/// A large field of a Nastran card: 16 characters, with as many digits as fit.
std::string large_field(double value) {
  std::array<char, 40> text;
  for (int digits = 15; digits > 0; --digits) {
    const auto end = std::to_chars(text.data(), text.data() + text.size(), value,
                                   std::chars_format::general, digits);
    std::string field(text.data(), end.ptr);
    const size_t exponent = field.find('e');
    if (field.find('.') == std::string::npos)
      field.insert(exponent == std::string::npos ? field.size() : exponent, ".");
    std::replace(field.begin(), field.end(), 'e', 'E');
    if (field.size() <= 16) return field + std::string(16 - field.size(), ' ');
  }
  return std::string(16, ' ');
}

std::string large_field(long value) {
  std::string field = std::to_string(value);
  return field + std::string(16 - std::min<size_t>(16, field.size()), ' ');
}

void write_nastran(std::ostream& out, const DerivativeTable& table) {
  const std::string blank(16, ' ');
  out << "$ Shape variables: X(new) = X + DVGRID (value - XINIT), in the basic system.\n"
         "$ X: nodes of the deck "
      << table.scene->mesh_out << ".\n";
  long id = 0;
  for (const MorphDerivative& d : *table.derivatives) {
    out << "$ DV" << ++id << ": " << printable(d.parameter.name) << "\n";
    std::string lower = d.parameter.min == 0 ? large_field(1e-6) : blank, upper = blank;
    for (const ParameterSweep& range : table.ranges)
      if (range.parameter == d.parameter.name) {
        lower = large_field(std::min(range.from, range.to));
        upper = large_field(std::max(range.from, range.to));
      }
    std::string label = "DV" + std::to_string(id);
    label.resize(16, ' ');
    out << "DESVAR* " << large_field(id) << label << large_field(d.parameter.value) << lower
        << "\n*       " << upper << "\n";
  }
  id = 0;
  for (const MorphDerivative& d : *table.derivatives) {
    ++id;
    const double negligible = 1e-14 * d.rate.cwiseAbs().maxCoeff();
    for (long v = 0; v < table.file->shells().node_count(); ++v) {
      if (!(d.rate.row(v).cwiseAbs().maxCoeff() > negligible)) continue;
      out << "DVGRID* " << large_field(id)
          << large_field(table.file->node_label(static_cast<int>(v))) << large_field(0L)
          << large_field(1.0) << "\n*       " << large_field(d.rate(v, 0))
          << large_field(d.rate(v, 1)) << large_field(d.rate(v, 2)) << "\n";
    }
  }
}

}  // namespace

std::string csv_cell(const std::string& text) {
  if (text.find_first_of(",;\"\n\r\t") == std::string::npos) return text;
  std::string cell = "\"";
  for (const char c : text) cell += c == '"' ? std::string("\"\"") : std::string(1, c);
  return cell + "\"";
}

void require_derivative_format(const std::filesystem::path& path, const MeshFile& file) {
  const std::string extension = lower_extension(path);
  if (extension == ".csv" || extension == ".npz") return;
  if (!is_nastran_extension(extension))
    throw InputError("--derivatives " + path.string() + ": found the extension '" + extension +
                     "', expected .csv, .npz, or .bdf for a Nastran deck");
  if (!file.format().starts_with("Nastran"))
    throw InputError("--derivatives " + path.string() + ": found a mesh that is " +
                     (file.format().empty() ? "no deck" : "a file of " + file.format()) +
                     ", expected a Nastran deck for DVGRID cards; .csv and .npz contain the "
                     "derivatives of any mesh");
}

void write_derivatives(const std::filesystem::path& path, const DerivativeTable& table) {
  const std::string extension = lower_extension(path);
  if (extension == ".npz") {
    AtomicFile file(path);
    write_npz(file.temporary(), table);
    file.commit();
    return;
  }
  write_file_atomically(path, [&](std::ostream& out) {
    extension == ".csv" ? write_csv(out, table) : write_nastran(out, table);
  });
}

}  // namespace batten
