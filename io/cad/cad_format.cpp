// SPDX-License-Identifier: MPL-2.0
#include "batten/io/cad/cad_format.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <sstream>
#include <utility>

#include "batten/core/errors.h"
#include "batten/io/files/input_file.h"
#include "batten/io/files/text.h"

namespace batten {
namespace {

[[noreturn]] void refuse(const std::filesystem::path& file, size_t line, const std::string& what) {
  throw InputError(file.string() + ", line " + std::to_string(line) + ": " + what);
}

std::vector<std::string> lines_of(const std::filesystem::path& file) {
  std::istringstream in(read_input_file(file, "a CAD file"));
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) {
    while (!line.empty() && std::isspace(static_cast<unsigned char>(line.back()))) line.pop_back();
    lines.push_back(line);
  }
  while (!lines.empty() && lines.back().empty()) lines.pop_back();
  if (lines.empty()) throw InputError(file.string() + ": empty; expected a CAD file");
  return lines;
}

/// The number in columns [from, from + width), counted from 0; -1 if there is none.
long field(const std::string& line, size_t from, size_t width) {
  if (line.size() <= from) return -1;
  char* end = nullptr;
  const std::string text = line.substr(from, width);
  const long value = std::strtol(text.c_str(), &end, 10);
  return end == text.c_str() ? -1 : value;
}

/// Checks an IGES file: lines of 80 columns, with the section letter in column 73 and the number
/// within the section after it. The last line holds the line counts of the other sections.
void check_iges(const std::filesystem::path& file, const std::vector<std::string>& lines) {
  const std::string sections = "SGDPT";
  std::array<size_t, 5> first{}, count{};
  size_t section = 0;
  for (size_t i = 0; i < lines.size(); ++i) {
    const char letter = lines[i].size() > 72 ? lines[i][72] : ' ';
    if (i == 0 && (letter == 'C' || letter == 'B'))
      refuse(file, 1, "compressed or binary IGES; expected the ASCII form in 80 columns");
    const size_t found = sections.find(letter);
    if (found == std::string::npos || found < section || (i == 0 && found != 0))
      refuse(file, i + 1,
             (lines[i].size() > 72 ? "found '" + std::string(1, letter) + "' in column 73"
                                   : "the line ends before column 73") +
                 "; expected the letter of an IGES section (S, G, D, P, T in this order): the file "
                 "is truncated or not IGES");
    if (found != section || i == 0) first[found] = i;
    section = found;
    if (field(lines[i], 73, 7) != static_cast<long>(++count[found]))
      refuse(file, i + 1,
             "line number " + lines[i].substr(std::min<size_t>(73, lines[i].size())) +
                 " in section " + letter + "; expected " + std::to_string(count[found]) +
                 ": a line is missing or truncated");
  }
  if (section != 4)
    refuse(file, lines.size(),
           "the file ends in section " + std::string(1, sections[section]) +
               "; expected a last line of section T: the file is truncated");
  for (size_t s = 0; s < 4; ++s)
    if (const long stated = field(lines.back(), 8 * s + 1, 7);
        stated != static_cast<long>(count[s]))
      refuse(file, lines.size(),
             "section " + std::string(1, sections[s]) + " should have " + std::to_string(stated) +
                 " lines; found " + std::to_string(count[s]));
  if (count[2] == 0 || count[2] % 2)
    refuse(
        file, lines.size(),
        std::to_string(count[2]) + " lines in the directory (section D); expected two per entity");
  for (size_t d = first[2]; d < first[2] + count[2]; d += 2) {
    const long start = field(lines[d], 8, 8), length = std::max(field(lines[d + 1], 24, 8), 0L);
    if (start < 1 || start + length - 1 > static_cast<long>(count[3]))
      refuse(file, d + 1,
             "the entity's data are lines " + std::to_string(start) + " to " +
                 std::to_string(start + length - 1) + " of section P, which has " +
                 std::to_string(count[3]));
  }
}

void check_step_text(const std::filesystem::path& file, const std::vector<std::string>& lines) {
  size_t first = 0;
  while (lines[first].empty()) ++first;
  if (lines[first].find("ISO-10303-21") == std::string::npos)
    refuse(file, first + 1,
           "found '" + lines[first].substr(0, 40) + "'; expected 'ISO-10303-21;' of a STEP file");
  if (lines.back().find("END-ISO-10303-21") == std::string::npos)
    refuse(file, lines.size(),
           "the file ends with '" + lines.back().substr(0, 40) +
               "'; expected 'END-ISO-10303-21;': the file is truncated");
}

constexpr const char* kBrepSections[] = {
    "Locations", "Curve2ds",       "Curves", "Polygon3D", "PolygonOnTriangulations",
    "Surfaces",  "Triangulations", "TShapes"};

/// Checks a binary BREP file. It has the same sections as the text form, with binary data in
/// between.
void check_binary_brep(const std::filesystem::path& file, const std::string& bytes) {
  size_t at = 0;
  for (const std::string name : kBrepSections) {
    const size_t found = bytes.find(name + " ", at);
    if (found == std::string::npos)
      throw InputError(file.string() + ": binary BREP without its section " + name +
                       " behind byte " + std::to_string(at) +
                       "; expected one: it is damaged or truncated");
    at = found + name.size() + 1;
    char* end = nullptr;
    const long count = std::strtol(bytes.c_str() + at, &end, 10);
    // Each item takes at least one byte.
    if (end == bytes.c_str() + at || count < 0 || count > static_cast<long>(bytes.size() - at))
      throw InputError(file.string() + ": found '" + bytes.substr(at, end - bytes.c_str() - at) +
                       "' as the count of " + name + " at byte " + std::to_string(at) +
                       ", before " + std::to_string(bytes.size() - at) +
                       " bytes; expected a count that fits");
  }
}

/// Finds the section "NAME COUNT" from line `from` on, and returns the index of its line.
size_t brep_section(const std::filesystem::path& file, const std::vector<std::string>& lines,
                    size_t from, const std::string& name, long& count) {
  for (size_t i = from; i < lines.size(); ++i) {
    if (!lines[i].starts_with(name + " ")) continue;
    char* end = nullptr;
    const std::string text = lines[i].substr(name.size() + 1);
    count = std::strtol(text.c_str(), &end, 10);
    // Each item takes at least one line.
    if (end == text.c_str() || count < 0 || count > static_cast<long>(lines.size() - i))
      refuse(file, i + 1,
             "found '" + lines[i].substr(0, 40) + "' before " +
                 std::to_string(lines.size() - i - 1) +
                 " lines; expected a count that fits: the file is damaged or truncated");
    return i;
  }
  refuse(file, lines.size(),
         "the file ends without its section " + name + "; expected one: it is truncated");
}

/// Checks a BREP text file. One of its first lines names the format, followed by sections, each
/// with a count. The list of each shape ends with '*', and the root shape follows the last.
void check_brep_text(const std::filesystem::path& file, const std::vector<std::string>& lines) {
  const auto first = std::find_if(
      lines.begin(), lines.begin() + std::min<long>(4, lines.size()),
      [](const auto& line) { return line.find("CASCADE Topology V") != std::string::npos; });
  if (first == lines.begin() + std::min<long>(4, lines.size()))
    refuse(file, 1,
           "found '" + lines[0].substr(0, 40) + "'; expected 'CASCADE Topology V…' of a BREP file");
  size_t at = 0;
  long count = 0;
  for (const char* name : kBrepSections) at = brep_section(file, lines, at, name, count);
  long shapes = 0;
  bool whole = false;  // true if text follows the last '*'
  for (size_t i = at + 1; i < lines.size(); ++i)
    for (const char c : lines[i]) {
      shapes += c == '*';
      whole = c != '*' && (whole || !std::isspace(static_cast<unsigned char>(c)));
    }
  if (shapes != count || count == 0 || !whole)
    refuse(file, lines.size(),
           "found " + std::to_string(shapes) + " of " + std::to_string(count) + " shapes" +
               (whole || shapes != count ? "" : ", the last one incomplete") +
               "; expected all: the file is truncated");
}

/// Refuses 'nan' and 'inf', which OpenCASCADE reads as numbers. Quoted text is skipped; in IGES, so
/// are words within text.
void refuse_not_finite(const std::filesystem::path& file, const std::vector<std::string>& lines,
                       CadFormat format) {
  const std::string between = format == CadFormat::Iges ? "(,);" : "(,); \t\r";
  bool quoted = false;
  for (size_t i = 0; i < lines.size(); ++i) {
    std::string token;
    for (const char c : lines[i] + between[0]) {
      if (format == CadFormat::Step && c == '\'') quoted = !quoted;
      if (between.find(c) == std::string::npos) {
        token += c;
        continue;
      }
      std::string letters = lower_case(std::exchange(token, {}));
      if (!letters.empty() && (letters[0] == '-' || letters[0] == '+')) letters.erase(0, 1);
      if (!quoted && (letters == "nan" || letters == "inf" || letters == "infinity"))
        refuse(file, i + 1, "found '" + letters + "'; expected a finite number");
    }
  }
}

}  // namespace

const std::vector<std::string>& cad_extensions() {
  static const std::vector<std::string> endings = {".iges", ".igs", ".step", ".stp",
                                                   ".brep", ".brp", ".xml"};
  return endings;
}

CadFormat cad_format(const std::filesystem::path& file) {
  const std::string extension = lower_extension(file);
  if (extension == ".igs" || extension == ".iges") return CadFormat::Iges;
  if (extension == ".stp" || extension == ".step") return CadFormat::Step;
  if (extension == ".brep" || extension == ".brp") return CadFormat::Brep;
  if (extension == ".xml") return CadFormat::Patches;
  throw InputError(file.string() + ": extension '" + extension +
                   "'; expected .igs, .iges, .stp, .step, .brep, .brp or .xml");
}

bool is_binary_brep(const std::string& bytes) {
  constexpr size_t head = 100;
  return bytes.substr(0, head).find("Open CASCADE Topology V") != std::string::npos;
}

void check_cad_text(const std::filesystem::path& file, CadFormat format) {
  if (format == CadFormat::Patches) return;  // the XML reader detects truncation
  if (format == CadFormat::Brep)
    if (const std::string bytes = read_input_file(file, "a BREP file"); is_binary_brep(bytes))
      return check_binary_brep(file, bytes);
  const auto lines = lines_of(file);
  refuse_not_finite(file, lines, format);
  format == CadFormat::Iges   ? check_iges(file, lines)
  : format == CadFormat::Step ? check_step_text(file, lines)
                              : check_brep_text(file, lines);
}

}  // namespace batten
