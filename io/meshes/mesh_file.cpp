// SPDX-License-Identifier: MPL-2.0
#include "batten/io/meshes/mesh_file.h"

#include <algorithm>
#include <map>

#include "batten/core/errors.h"
#include "batten/io/meshes/mesh_content.h"

namespace batten {
namespace fs = std::filesystem;

namespace {

[[noreturn]] void refuse_extension(const fs::path& path, const std::string& expected) {
  const std::string extension = path.extension().string();
  throw InputError(path.string() + ": found " +
                   (extension.empty() ? "no extension" : "the extension '" + extension + "'") +
                   ", expected " + expected);
}

std::string either_of(const std::vector<std::string>& alternatives) {
  std::string text;
  for (size_t i = 0; i < alternatives.size(); ++i)
    text += (i == 0 ? "" : i + 1 == alternatives.size() ? " or " : ", ") + alternatives[i];
  return text;
}

template <class Function>
Function* by_extension(const fs::path& path, const std::map<std::string, Function*>& functions) {
  const auto found = functions.find(lower_extension(path));
  if (found != functions.end()) return found->second;
  std::vector<std::string> known;
  for (const auto& [extension, function] : functions) known.push_back(extension);
  refuse_extension(path, either_of(known));
}

const std::map<std::string, MeshContentReader*>& readers() {
  static const std::map<std::string, MeshContentReader*> all{
      {".obj", read_obj_mesh},     {".off", read_off_mesh},     {".ply", read_ply_mesh},
      {".stl", read_stl_mesh},     {".vtp", read_vtk_mesh},     {".vtu", read_vtk_mesh},
      {".vtk", read_vtk_mesh},     {".bdf", read_nastran_deck}, {".nas", read_nastran_deck},
      {".dat", read_nastran_deck}, {".inp", read_abaqus_deck},  {".k", read_lsdyna_deck},
      {".key", read_lsdyna_deck},  {".dyn", read_lsdyna_deck},  {".rad", read_radioss_deck},
      {".fem", read_nastran_deck}, {".msh", read_gmsh_mesh},    {".unv", read_gmsh_mesh}};
  return all;
}

/// Content of a mesh that was not read from a file; write() throws InputError.
struct CountedMesh : MeshContent {
  MeshRounding write(const fs::path& path, const Points&, const MeshWriteOptions&) const override {
    throw InputError(path.string() + ": found a mesh that was not read from a single file");
  }
};

}  // namespace

MeshFile::MeshFile(std::shared_ptr<const MeshContent> content) : content_(std::move(content)) {}

MeshFile MeshFile::from_shells(ShellMesh shells) {
  auto content = std::make_unique<CountedMesh>();
  content->format = "frames";
  content->node_labels = Labels::counted_from(1, shells.node_count());
  content->face_labels = Labels::counted_from(1, shells.face_count());
  content->shells = std::move(shells);
  return MeshFile(std::move(content));
}

MeshFile MeshFile::read(const fs::path& path) {
  std::unique_ptr<MeshContent> content = by_extension(path, readers())(path);
  if (content->shells.face_count() == 0)
    throw InputError(path.string() + ": found " +
                     format_count(content->shells.node_count(), "node") +
                     " but no faces, expected at least one");
  return MeshFile(std::move(content));
}

bool MeshFile::can_read(const fs::path& path) { return readers().contains(lower_extension(path)); }

std::vector<std::string> MeshFile::readable_extensions() {
  std::vector<std::string> all;
  for (const auto& [extension, reader] : readers()) all.push_back(extension);
  return all;
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
const std::vector<NonShellElement>& MeshFile::other_elements() const {
  return content_->other_elements;
}
const std::vector<SurfaceTie>& MeshFile::ties() const { return content_->ties; }
const CageTags& MeshFile::cage_tags() const {
  if (!content_->cage_problem.empty()) throw InputError(content_->cage_problem);
  return content_->cage_tags;
}
const std::vector<std::string>& MeshFile::warnings() const { return content_->warnings; }
const std::string& MeshFile::element_counts() const { return content_->element_counts; }
const std::string& MeshFile::format() const { return content_->format; }

std::vector<fs::path> MeshFile::included_files() const { return content_->included_files(); }
fs::path MeshFile::folder_in_tree() const { return content_->folder_in_tree(); }

MeshFile::Rounding MeshFile::write(const fs::path& path, const Points& points,
                                   const MeshWriteOptions& options) const {
  const auto& extensions = content_->extensions;
  if (std::find(extensions.begin(), extensions.end(), lower_extension(path)) == extensions.end())
    refuse_extension(path, either_of(extensions) + ": the mesh was read as " + content_->format);
  if (points.rows() != shells().node_count())
    throw InputError(path.string() + ": found " + format_count(points.rows(), "point") +
                     ", expected " + std::to_string(shells().node_count()) +
                     " as in the file that was read");
  for (int i = 0; i < points.rows(); ++i)
    if (!points.row(i).allFinite())
      throw InputError(path.string() + ": a coordinate of node " + std::to_string(node_label(i)) +
                       " is not finite");
  return content_->write(path, points, options);
}

namespace {

using MeshWriter = std::vector<fs::path>(const MeshOutput&);

/// Adapts the writer of a format without additional files.
template <void (*write)(const MeshOutput&)>
std::vector<fs::path> alone(const MeshOutput& output) {
  write(output);
  return {};
}

const std::map<std::string, MeshWriter*>& writers() {
  static const std::map<std::string, MeshWriter*> all{{".obj", write_obj_mesh},
                                                      {".off", alone<write_off_mesh>},
                                                      {".ply", alone<write_ply_mesh>},
                                                      {".stl", alone<write_stl_mesh>},
                                                      {".vtp", alone<write_vtk_mesh>},
                                                      {".vtu", alone<write_vtk_mesh>},
                                                      {".glb", alone<write_glb_mesh>},
                                                      {".3mf", alone<write_3mf_mesh>},
                                                      {".inp", alone<write_abaqus_mesh>},
                                                      {".bdf", alone<write_nastran_mesh>},
                                                      {".nas", alone<write_nastran_mesh>},
                                                      {".fem", alone<write_nastran_mesh>}};
  return all;
}

}  // namespace

const std::vector<std::string>& mesh_file_endings() {
  static const std::vector<std::string> endings = [] {
    std::vector<std::string> all;
    for (const auto& [ending, writer] : writers()) all.push_back(ending);
    return all;
  }();
  return endings;
}

std::vector<fs::path> write_mesh(const fs::path& path, const ShellMesh& mesh,
                                 const std::vector<MeshSet>& sets, double unit_in_metres) {
  MeshWriter* const write = by_extension(path, writers());
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
             format_count(static_cast<long>(nodes.size()), "node") + ", expected 3 or more");
    for (const int node : nodes)
      if (node < 0 || node >= mesh.node_count())
        refuse("face " + std::to_string(f) + " has node " + std::to_string(node) +
               ", expected 0 to " + std::to_string(mesh.node_count() - 1));
  }
  const std::string ending = lower_extension(path);
  if ((ending == ".glb" || ending == ".3mf") && !(unit_in_metres > 0))
    refuse("found no length unit, expected one: files of this type state it");
  return write({path, mesh, sets, unit_in_metres});
}

}  // namespace batten
