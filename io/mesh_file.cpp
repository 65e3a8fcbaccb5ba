#include "batten/io/mesh_file.h"

#include <algorithm>
#include <cctype>
#include <limits>
#include <map>

#include "batten/core/errors.h"
#include "batten/io/mesh_content.h"

namespace batten {
namespace fs = std::filesystem;

Labels Labels::counted_from(long first, int count) {
  Labels labels;
  labels.first_ = first;
  labels.count_ = count;
  return labels;
}

Labels::Labels(std::vector<long> labels)
    : count_(static_cast<int>(labels.size())), labels_(std::move(labels)) {
  if (labels_.empty()) return;
  const auto [low, high] = std::minmax_element(labels_.begin(), labels_.end());
  first_ = *low;
  const auto range = static_cast<unsigned long>(*high) - static_cast<unsigned long>(*low);
  if (range < 4 * labels_.size() + 1024) {
    dense_.assign(range + 1, -1);
    for (int i = 0; i < count_; ++i) {
      int& there = dense_[static_cast<size_t>(labels_[i] - first_)];
      if (there >= 0 && !twice_) twice_ = {there, i};
      there = i;
    }
    return;
  }
  for (int i = 0; i < count_; ++i) by_label_.push_back({labels_[i], i});
  std::sort(by_label_.begin(), by_label_.end());
  for (size_t i = 1; i < by_label_.size(); ++i)
    if (by_label_[i].first == by_label_[i - 1].first &&
        (!twice_ || by_label_[i].second < twice_->second))
      twice_ = {by_label_[i - 1].second, by_label_[i].second};
}

std::optional<int> Labels::find(long label) const {
  if (!by_label_.empty()) {
    const auto at = std::lower_bound(by_label_.begin(), by_label_.end(), std::pair(label, 0));
    if (at == by_label_.end() || at->first != label) return {};
    return at->second;
  }
  if (count_ == 0 || label < first_) return {};
  const auto index = static_cast<unsigned long>(label) - static_cast<unsigned long>(first_);
  if (labels_.empty())
    return index < static_cast<unsigned long>(count_) ? std::optional(static_cast<int>(index))
                                                      : std::nullopt;
  if (index >= dense_.size() || dense_[index] < 0) return {};
  return dense_[index];
}

std::string counted(long count, const std::string& noun) {
  return std::to_string(count) + " " + noun + (count == 1 ? "" : "s");
}

std::string lower_extension(const fs::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension;
}

int unused_nodes(const ShellMesh& mesh) {
  std::vector<char> used(static_cast<size_t>(mesh.node_count()));
  for (int f = 0; f < mesh.face_count(); ++f)
    for (const int node : mesh.face(f)) used[static_cast<size_t>(node)] = 1;
  return static_cast<int>(std::count(used.begin(), used.end(), 0));
}

std::vector<int> outline_of(const ShellMesh& mesh, int face) {
  const auto nodes = mesh.face(face), corners = mesh.corners(face);
  if (!mesh.second_order(face)) return {nodes.begin(), nodes.end()};
  std::vector<int> outline;
  for (size_t i = 0; i < corners.size(); ++i) {
    outline.push_back(corners[i]);
    outline.push_back(nodes[corners.size() + i]);
  }
  return outline;
}

namespace {

[[noreturn]] void refuse_extension(const fs::path& path, const std::string& expected) {
  const std::string extension = path.extension().string();
  throw InputError(path.string() + ": found " +
                   (extension.empty() ? "no extension" : "the extension '" + extension + "'") +
                   ", expected " + expected);
}

std::string listed(const std::vector<std::string>& words) {
  std::string text;
  for (size_t i = 0; i < words.size(); ++i)
    text += (i == 0 ? "" : i + 1 == words.size() ? " or " : ", ") + words[i];
  return text;
}

template <class Function>
Function* by_extension(const fs::path& path, const std::map<std::string, Function*>& functions) {
  const auto found = functions.find(lower_extension(path));
  if (found != functions.end()) return found->second;
  std::vector<std::string> known;
  for (const auto& [extension, function] : functions) known.push_back(extension);
  refuse_extension(path, listed(known));
}

}  // namespace

MeshFile::MeshFile(std::shared_ptr<const MeshContent> content) : content_(std::move(content)) {}

MeshFile MeshFile::read(const fs::path& path) {
  static const std::map<std::string, MeshContentReader*> readers{
      {".obj", read_obj_mesh},     {".off", read_off_mesh},     {".ply", read_ply_mesh},
      {".stl", read_stl_mesh},     {".vtp", read_vtk_mesh},     {".vtu", read_vtk_mesh},
      {".bdf", read_nastran_deck}, {".nas", read_nastran_deck}, {".dat", read_nastran_deck},
      {".inp", read_abaqus_deck},  {".k", read_lsdyna_deck},    {".key", read_lsdyna_deck},
      {".dyn", read_lsdyna_deck}};
  std::unique_ptr<MeshContent> content = by_extension(path, readers)(path);
  if (content->shells.face_count() == 0)
    throw InputError(path.string() + ": found " + counted(content->shells.node_count(), "node") +
                     " but no faces, expected some");
  return MeshFile(std::move(content));
}

const ShellMesh& MeshFile::shells() const { return content_->shells; }
long MeshFile::node_label(int node) const { return content_->node_labels.of(node); }
long MeshFile::face_label(int face) const { return content_->face_labels.of(face); }
std::optional<int> MeshFile::node_of_label(long label) const {
  return content_->node_labels.find(label);
}
std::optional<int> MeshFile::face_of_label(long label) const {
  return content_->face_labels.find(label);
}
const std::vector<MeshFile::Set>& MeshFile::sets() const { return content_->sets; }
const std::vector<MeshFile::Set>& MeshFile::properties() const { return content_->properties; }
const std::vector<std::string>& MeshFile::warnings() const { return content_->warnings; }
const std::string& MeshFile::format() const { return content_->format; }

MeshFile::Rounding MeshFile::write(const fs::path& path, const Points& points,
                                   const MeshWriteOptions& options) const {
  const auto& extensions = content_->extensions;
  if (std::find(extensions.begin(), extensions.end(), lower_extension(path)) == extensions.end())
    refuse_extension(path, listed(extensions) + ": the mesh was read as " + content_->format);
  if (points.rows() != shells().node_count())
    throw InputError(path.string() + ": found " + counted(points.rows(), "point") + ", expected " +
                     std::to_string(shells().node_count()) + " as in the file that was read");
  for (int i = 0; i < points.rows(); ++i)
    if (!points.row(i).allFinite())
      throw InputError(path.string() + ": a coordinate of node " + std::to_string(node_label(i)) +
                       " is not finite");
  return content_->write(path, points, options);
}

void write_mesh(const fs::path& path, const ShellMesh& mesh) {
  using Writer = void(const fs::path&, const ShellMesh&);
  static const std::map<std::string, Writer*> writers{
      {".obj", write_obj_mesh}, {".off", write_off_mesh}, {".ply", write_ply_mesh},
      {".stl", write_stl_mesh}, {".vtp", write_vtk_mesh}, {".vtu", write_vtk_mesh}};
  Writer* const write = by_extension(path, writers);
  const auto refuse = [&](const std::string& what) {
    throw InputError(path.string() + ": " + what);
  };
  for (int i = 0; i < mesh.node_count(); ++i)
    if (!mesh.points.row(i).allFinite())
      refuse("a coordinate of node " + std::to_string(i) + " is not finite");
  for (int f = 0; f < mesh.face_count(); ++f) {
    const auto nodes = mesh.face(f);
    if (nodes.size() < 3)
      refuse("face " + std::to_string(f) + " has " +
             counted(static_cast<long>(nodes.size()), "node") + ", expected 3 or more");
    for (const int node : nodes)
      if (node < 0 || node >= mesh.node_count())
        refuse("face " + std::to_string(f) + " has node " + std::to_string(node) +
               ", expected 0 to " + std::to_string(mesh.node_count() - 1));
  }
  write(path, mesh);
}

}  // namespace batten
