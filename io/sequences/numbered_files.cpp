// SPDX-License-Identifier: MPL-2.0
// Names of numbered files, and series of them: the names that patterns stand for, and their frames.
#include <algorithm>
#include <charconv>
#include <map>
#include <numeric>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/io/files/input_file.h"
#include "batten/io/files/text.h"
#include "batten/io/files/toml_table.h"
#include "batten/io/meshes/mesh_file.h"
#include "batten/io/sequences/sequence_files.h"

namespace batten {
namespace fs = std::filesystem;
namespace {

constexpr std::string_view kDigits = "0123456789";

/// Splits a file name around the last number in its stem; empty if there is no number.
std::optional<NumberedName> name_around(const fs::path& path) {
  const std::string stem = path.stem().string();
  const size_t last = stem.find_last_of(kDigits);
  if (last == stem.npos) return {};
  const size_t prefix = stem.find_last_not_of(kDigits, last);
  const size_t first = prefix == stem.npos ? 0 : prefix + 1;
  return NumberedName{path.parent_path(), stem.substr(0, first),
                      stem.substr(last + 1) + path.extension().string(),
                      static_cast<int>(last + 1 - first)};
}

std::vector<fs::path> files_in(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code error;
  for (fs::directory_iterator entry(folder.empty() ? "." : folder, error), end;
       !error && entry != end; entry.increment(error))
    if (std::error_code ignored; entry->is_regular_file(ignored))
      files.push_back(folder / entry->path().filename());
  if (error) throw InputError(folder.string() + ": cannot read this folder: " + error.message());
  std::sort(files.begin(), files.end());
  return files;
}

std::vector<NumberedFile> files_of(const NumberedName& name) {
  std::vector<NumberedFile> files;
  for (const fs::path& file : files_in(name.folder))
    if (const auto number = name.number_of(file.filename().string()))
      files.push_back({file, *number});
  std::stable_sort(files.begin(), files.end(), [](const NumberedFile& a, const NumberedFile& b) {
    return a.number < b.number;
  });
  for (size_t i = 1; i < files.size(); ++i)
    if (files[i].number == files[i - 1].number)
      throw InputError(files[i].path.string() + ": found the number " +
                       std::to_string(files[i].number) + " also in " +
                       files[i - 1].path.filename().string() + ", expected each number once");
  return files;
}

/// The only series of mesh files in a folder; single files are considered if there is no longer
/// series.
NumberedName series_in(const fs::path& folder) {
  std::map<std::string, std::vector<NumberedName>> series;
  for (const fs::path& file : files_in(folder))
    if (MeshFile::can_read(file))
      if (const auto name = name_around(file)) series[name->pattern()].push_back(*name);
  std::vector<std::string> found;
  for (const size_t least : {2, 1}) {
    for (const auto& [pattern, files] : series)
      if (files.size() >= least) found.push_back(fs::path(pattern).filename().string());
    if (!found.empty()) break;
  }
  if (found.size() == 1) return series.at((folder / found.front()).string()).front();
  if (found.empty())
    throw InputError(folder.string() +
                     ": found no numbered mesh files in this folder, expected at least one");
  throw InputError(folder.string() + ": found " + std::to_string(found.size()) +
                   " series of files, " + comma_separated(found) + "; name one of them");
}

}  // namespace

std::string NumberedName::pattern() const { return (folder / (prefix + "*" + suffix)).string(); }

fs::path NumberedName::file(long number) const {
  std::string text = std::to_string(number);
  if (text.size() < static_cast<size_t>(digits))
    text.insert(0, static_cast<size_t>(digits) - text.size(), '0');
  return folder / (prefix + text + suffix);
}

std::optional<long> NumberedName::number_of(const std::string& file_name) const {
  if (file_name.size() <= prefix.size() + suffix.size() || !file_name.starts_with(prefix) ||
      !file_name.ends_with(suffix))
    return {};
  const char* const first = file_name.data() + prefix.size();
  const char* const last = file_name.data() + file_name.size() - suffix.size();
  long number = 0;
  const auto [end, error] = std::from_chars(first, last, number);
  if (*first == '-' || end != last || error != std::errc()) return {};
  return number;
}

std::optional<NumberedName> pattern_of(const fs::path& path) {
  const std::string name = path.filename().string();
  const auto refuse = [&](const std::string& found) {
    throw InputError(path.string() + ": found " + found +
                     ", expected one * or %04d in the file's name");
  };
  if (path.parent_path().string().find('*') != std::string::npos) refuse("a * in the folder");
  const size_t at = name.find_first_of("*%");
  if (at == name.npos) return {};
  NumberedName result{path.parent_path(), name.substr(0, at), "", 4};
  size_t end = at + 1;
  if (name[at] == '%') {
    end = name.find_first_not_of(kDigits, end);
    const std::string digits = name.substr(at + 1, std::min(end, name.size()) - at - 1);
    if (end == name.npos || name[end] != 'd' || digits.size() > 2) refuse("a % without digits, d");
    result.digits = digits.empty() ? 1 : std::max(1, std::stoi(digits));
    ++end;
  }
  result.suffix = name.substr(end);
  if (result.suffix.find_first_of("*%") != std::string::npos)
    refuse("several patterns for a number");
  return result;
}

std::vector<NumberedFile> numbered_files(const fs::path& path, std::string& name) {
  std::error_code ignored;
  std::optional<NumberedName> series;
  if (fs::is_directory(path, ignored)) {
    series = series_in(path);
  } else if (fs::exists(path, ignored) || !(series = pattern_of(path))) {
    if (!MeshFile::can_read(path))
      throw InputError(
          path.string() +
          ": expected a folder, a pattern such as walk_*.obj, a mesh file, .pvd, .pc2, "
          ".mdd, .gltf, .glb or .frd");
    series = name_around(path);
    if (!series || !fs::exists(path, ignored)) {
      name = path.string();
      return {{path, 1}};
    }
  }
  name = series->pattern();
  std::vector<NumberedFile> files = files_of(*series);
  if (files.empty()) throw InputError(name + ": found no such files, expected numbered ones");
  return files;
}

void require_no_gaps(const std::vector<NumberedFile>& files, const std::string& name) {
  long stride = 0;
  for (size_t i = 1; i < files.size(); ++i)
    stride = std::gcd(stride, files[i].number - files[i - 1].number);
  std::vector<std::string> missing;
  long count = 0;
  for (size_t i = 1; i < files.size(); ++i) {
    count += (files[i].number - files[i - 1].number) / stride - 1;
    for (long n = files[i - 1].number + stride; n < files[i].number && missing.size() < 8;
         n += stride)
      missing.push_back(std::to_string(n));
  }
  if (count == 0) return;
  throw InputError(name + ": found no file for " + (count == 1 ? "number " : "the numbers ") +
                   comma_separated(missing) +
                   (count > isize(missing)
                        ? " and " + std::to_string(count - isize(missing)) + " more"
                        : std::string()) +
                   ", expected all from " + std::to_string(files.front().number) + " to " +
                   std::to_string(files.back().number) +
                   (stride > 1 ? " in steps of " + std::to_string(stride) : std::string()));
}

// Numbered files, and ParaView's list of files (.pvd).

namespace {

[[noreturn]] void differs(const fs::path& file, const std::string& found, const fs::path& first,
                          const std::string& expected) {
  throw InputError(file.string() + ": found " + found + ", expected " + expected + " as in " +
                   first.filename().string());
}

std::string listed_nodes(const MeshFile& mesh, int face) {
  std::string text;
  for (const int node : mesh.shells().face(face))
    text += (text.empty() ? "" : " ") + std::to_string(mesh.node_label(node));
  return text;
}

/// Throws InputError if the faces differ.
void require_same(const MeshFile& mesh, const fs::path& file, const MeshFile& first,
                  const fs::path& first_file) {
  const ShellMesh &a = mesh.shells(), &b = first.shells();
  if (a.node_count() != b.node_count())
    differs(file, format_count(a.node_count(), "node"), first_file, std::to_string(b.node_count()));
  if (a.face_count() != b.face_count())
    differs(file, format_count(a.face_count(), "face"), first_file, std::to_string(b.face_count()));
  for (int f = 0; f < a.face_count(); ++f)
    if (!std::ranges::equal(a.face(f), b.face(f)) || a.second_order(f) != b.second_order(f))
      differs(
          file,
          "face " + std::to_string(mesh.face_label(f)) + " with the nodes " + listed_nodes(mesh, f),
          first_file, listed_nodes(first, f));
  for (int i = 0; i < a.node_count(); ++i)
    if (mesh.node_label(i) != first.node_label(i))
      differs(file, "node " + std::to_string(mesh.node_label(i)), first_file,
              std::to_string(first.node_label(i)));
}

/// Points of an STL file in the node order of the first file, found by triangle corners: the STL
/// reader numbers nodes for each file separately.
Points points_by_corners(const ShellMesh& mesh, const fs::path& file, const ShellMesh& first,
                         const fs::path& first_file) {
  if (mesh.face_count() != first.face_count())
    differs(file, format_count(mesh.face_count(), "triangle"), first_file,
            std::to_string(first.face_count()));
  Points points(first.node_count(), 3);
  std::vector<int> found(static_cast<size_t>(first.node_count()), -1);
  const double size = (mesh.points.colwise().maxCoeff() - mesh.points.colwise().minCoeff()).norm();
  for (int f = 0; f < first.face_count(); ++f)
    for (size_t k = 0; k < 3; ++k) {
      const int node = first.face(f)[k];
      const auto position = mesh.points.row(mesh.face(f)[k]);
      if (found[node] < 0) {
        found[node] = f;
        points.row(node) = position;
        continue;
      }
      const double apart = (points.row(node) - position).norm();
      if (apart > kWeldTolerance * size)
        throw InputError(file.string() + ": node " + std::to_string(node) + " of the first file (" +
                         first_file.filename().string() + ") has two positions, " +
                         format_number(apart) + " apart: as a corner of triangle " +
                         std::to_string(found[node]) + " and of triangle " + std::to_string(f));
    }
  return points;
}

void require_finite(const Points& points, const MeshFile& mesh, const fs::path& file) {
  for (int i = 0; i < points.rows(); ++i)
    if (!points.row(i).allFinite())
      throw InputError(file.string() + ": a coordinate of node " +
                       std::to_string(mesh.node_label(i)) + " is not finite");
}

struct TimedFile {
  fs::path path;
  double time = 0;
};

/// Faces and node count come from the first file, even if its frame is not read.
MeshSequence read_files(const std::vector<TimedFile>& files, const FrameRange& range,
                        const Progress& progress) {
  MeshSequence sequence;
  progress.update("reading frames", 0);
  const fs::path& first_file = files.front().path;
  const MeshFile first = MeshFile::read(first_file);
  sequence.shells = first.shells();
  require_frame_memory(first_file, range.count, sequence.node_count());
  const bool corners = lower_extension(first_file) == ".stl";
  for (int k = range.first; k < range.first + range.count; ++k) {
    progress.update("reading frames", static_cast<double>(k - range.first) / range.count);
    const fs::path& file = files[k].path;
    const MeshFile mesh = k == 0 ? first : MeshFile::read(file);
    if (!corners) require_same(mesh, file, first, first_file);
    Points points = corners ? points_by_corners(mesh.shells(), file, first.shells(), first_file)
                            : mesh.shells().points;
    require_finite(points, first, file);
    sequence.frames.push_back(std::move(points));
    sequence.times.push_back(files[k].time);
  }
  return sequence;
}

/// The value of an attribute in the text of an XML tag; empty if it is missing.
std::string attribute(std::string_view tag, const std::string& name) {
  for (size_t at = tag.find(name); at != tag.npos; at = tag.find(name, at + 1)) {
    if (at == 0 || !(is_blank(tag[at - 1]) || tag[at - 1] == '\n')) continue;
    std::string_view rest = trimmed(tag.substr(at + name.size()));
    if (!rest.starts_with('=')) continue;
    rest = trimmed(rest.substr(1));
    if (rest.empty() || (rest[0] != '"' && rest[0] != '\'')) continue;
    const size_t end = rest.find(rest[0], 1);
    if (end == rest.npos) continue;
    std::string value(rest.substr(1, end - 1));
    const std::pair<std::string, std::string> named[] = {
        {"&lt;", "<"}, {"&gt;", ">"}, {"&quot;", "\""}, {"&apos;", "'"}, {"&amp;", "&"}};
    for (const auto& [code, sign] : named)
      for (size_t found = value.find(code); found != value.npos;
           found = value.find(code, found + 1))
        value.replace(found, code.size(), sign);
    return value;
  }
  return {};
}

/// Removes XML comments.
std::string without_comments(const std::string& text) {
  std::string rest;
  size_t done = 0;
  while (done < text.size()) {
    const size_t begin = std::min(text.find("<!--", done), text.size());
    rest.append(text, done, begin - done);
    const size_t end = text.find("-->", begin);
    done = end == text.npos ? text.size() : end + 3;
  }
  return rest;
}

std::vector<TimedFile> files_of_pvd(const fs::path& path) {
  const std::string text =
      without_comments(read_input_file(path, "ParaView's list of files (.pvd)"));
  const std::string name = path.string();
  if (text.find("<Collection") == text.npos)
    throw InputError(name + ": found no <Collection>, expected ParaView's list of files");
  std::vector<TimedFile> files;
  for (size_t at = text.find("<DataSet"); at != text.npos; at = text.find("<DataSet", at + 1)) {
    const size_t end = text.find('>', at);
    if (end == text.npos)
      throw InputError(name + ": found the end of the file in a <DataSet>, expected '>'");
    const std::string_view tag = std::string_view(text).substr(at + 8, end - at - 8);
    const std::string file = attribute(tag, "file"), time = attribute(tag, "timestep");
    const std::string which = "<DataSet> " + std::to_string(files.size() + 1);
    if (file.empty()) throw InputError(name + ": found no file in " + which + ", expected one");
    double value = static_cast<double>(files.size());
    const auto parsed = std::from_chars(time.data(), time.data() + time.size(), value);
    if (!time.empty() && (parsed.ec != std::errc() || parsed.ptr != time.data() + time.size()))
      throw InputError(name + ": found the timestep '" + time + "' in " + which +
                       ", expected a number");
    if (!files.empty() && !(value > files.back().time))
      throw InputError(name + ": found the timestep " + format_number(value) + " in " + which +
                       " after " + format_number(files.back().time) +
                       ", expected ascending timesteps with one file each");
    files.push_back({path.parent_path() / file, value});
  }
  return files;
}

}  // namespace

MeshSequence read_numbered_sequence(const fs::path& path, const SequenceOptions& options,
                                    const Progress& progress) {
  std::string name;
  std::vector<NumberedFile> numbered = numbered_files(path, name);
  if (!options.allow_gaps) require_no_gaps(numbered, name);
  std::vector<TimedFile> files;
  for (NumberedFile& file : numbered)
    files.push_back({std::move(file.path), static_cast<double>(file.number)});
  return read_files(files, frame_range(options, isize(files), name), progress);
}

MeshSequence read_pvd_sequence(const fs::path& path, const SequenceOptions& options,
                               const Progress& progress) {
  const std::vector<TimedFile> files = files_of_pvd(path);
  return read_files(files, frame_range(options, isize(files), path.string()), progress);
}

}  // namespace batten
