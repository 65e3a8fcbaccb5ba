// Numbered files, and ParaView's list of files.
#include <algorithm>
#include <charconv>

#include "batten/core/errors.h"
#include "batten/core/isize.h"
#include "batten/io/files/input_file.h"
#include "batten/io/files/text.h"
#include "batten/io/meshes/mesh_file.h"
#include "batten/io/sequences/numbered_files.h"
#include "batten/io/sequences/sequence_readers.h"

namespace batten {
namespace fs = std::filesystem;
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

/// Throws unless the faces are the same.
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

/// The nodes of an STL file by the corners that they have in the first one: each reader of STL
/// makes nodes of its own.
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
                         first_file.filename().string() + ") lies at two places, " +
                         format_number(apart) + " apart: at a corner of triangle " +
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

/// Faces and numbers of nodes are those of the first file, also where its frame is not read.
MeshSequence read_files(const std::vector<TimedFile>& files, const FrameRange& range,
                        const Progress& progress) {
  MeshSequence sequence;
  progress.update("reading frames", 0);
  const fs::path& first_file = files.front().path;
  const MeshFile first = MeshFile::read(first_file);
  sequence.shells = first.shells();
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

/// The value of an attribute in the text of a tag; empty without it.
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

/// The text without <!-- comments -->.
std::string without_comments(std::string text) {
  for (size_t at = text.find("<!--"); at != text.npos; at = text.find("<!--", at)) {
    const size_t end = text.find("-->", at);
    text.erase(at, end == text.npos ? text.npos : end + 3 - at);
  }
  return text;
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
                       ", expected ascending ones: of one part, one file a time");
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
