#include "batten/io/vtk/vtk_series.h"

#include <array>
#include <charconv>
#include <cmath>

#include "batten/core/errors.h"
#include "batten/io/files/atomic_file.h"

namespace batten {
namespace {

std::string all_digits(double value) {
  std::array<char, 32> text;
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
  return {text.data(), end};
}

std::string escaped(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (c == '&')
      result += "&amp;";
    else if (c == '<')
      result += "&lt;";
    else if (c == '"')
      result += "&quot;";
    else
      result += c;
  }
  return result;
}

}  // namespace

void write_pvd(const std::filesystem::path& path, const std::vector<SeriesFile>& files) {
  if (files.empty()) throw InputError(path.string() + ": found no files, expected a series");
  for (size_t i = 0; i < files.size(); ++i) {
    if (!std::isfinite(files[i].value))
      throw InputError(path.string() + ": found the value " + format_number(files[i].value) +
                       ", expected finite numbers");
    if (i > 0 && !((files[i].value - files[i - 1].value) * (files[1].value - files[0].value) > 0))
      throw InputError(path.string() + ": found the value " + format_number(files[i].value) +
                       " after " + format_number(files[i - 1].value) +
                       ", expected values in one direction");
  }
  write_file_atomically(path, [&](std::ostream& out) {
    out << "<?xml version=\"1.0\"?>\n"
           "<VTKFile type=\"Collection\" version=\"0.1\" byte_order=\"LittleEndian\">\n"
           "  <Collection>\n";
    for (const SeriesFile& f : files)
      out << "    <DataSet timestep=\"" << all_digits(f.value) << "\" group=\"\" part=\"0\" file=\""
          << escaped(f.file) << "\"/>\n";
    out << "  </Collection>\n</VTKFile>\n";
  });
}

}  // namespace batten
