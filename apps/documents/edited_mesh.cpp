// SPDX-License-Identifier: MPL-2.0
#include "batten/apps/documents/edited_mesh.h"

#include <algorithm>
#include <iterator>

#include "batten/core/containers.h"
#include "batten/io/files/text.h"
#include "batten/io/scene/scene_parsing.h"
#include "batten/scenes/commands.h"
#include "batten/scenes/meshes/morph_solver.h"
#include "batten/scenes/runs/run_support.h"

namespace batten {
namespace {

/// Tables that use the shape without changing it.
constexpr const char* kMadeOf[] = {"name", "output", "modes", "picture"};

/// The text of a scene without layout, handle values, and output files.
std::string extract_topology_text(const std::string& text) {
  toml::table root = parse_toml(text, {}, "a deform scene");
  for (const char* kind : kMadeOf) root.erase(kind);
  if (toml::array* edits = root["edit"].as_array())
    for (toml::node& edit : *edits)
      for (const char* kind : {"handle", "scale"})
        if (toml::array* moved = edit.is_table() ? (*edit.as_table())[kind].as_array() : nullptr)
          for (toml::node& one : *moved)
            if (toml::table* table = one.as_table())
              for (const char* number : {"translate", "rotate", "scale", "factor"})
                table->erase(number);
  return to_toml(root);
}

/// Unit of a handle's value: a length, except for rotations and scales.
std::string unit_of_move(const std::string& parameter, const std::string& length) {
  if (parameter.find(".rotation.") != std::string::npos || parameter.ends_with(".angle"))
    return "°";
  return parameter.ends_with(".scale") ? "" : length;
}

/// The scene without edits that do not yet fix or move anything.
DeformScene without_unfinished_edits(DeformScene scene) {
  std::erase_if(scene.edits, [&](const EditSpec& edit) {
    return edit.handles.empty() && edit.fixed.empty() && edit.scales.empty() &&
           edit.rotated_features.empty() && edit.guides.empty() &&
           scene.position_constraints.empty() && scene.targets.empty();
  });
  return scene;
}

using Part = MeshView::Part;
using Role = MeshView::Role;

}  // namespace

/// Everything derived from one scene. Members refer to preceding members.
struct EditedMesh::State {
  State(const DeformScene& scene, std::shared_ptr<const MeshSource> mesh)
      : source(std::move(mesh)), solver(without_unfinished_edits(scene), *source) {}

  const TriangleMesh& mesh() const { return solver.mesh(); }
  void show();
  void show_parts(MeshView& seen);
  void show_roles(MeshView& seen) const;
  /// The display points of nodes.
  std::vector<int> points(const std::vector<int>& nodes) const;

  std::shared_ptr<const MeshSource> source;
  MorphSolver solver;
  std::unique_ptr<const MeshDisplay> display;
  std::vector<std::string> line_names;
  std::vector<std::vector<int>> points_of;  // per node
  std::shared_ptr<const MeshView> view;
};

EditedMesh::EditedMesh() = default;
EditedMesh::~EditedMesh() = default;

void EditedMesh::rebuild(const SceneText& text, const std::filesystem::path& file,
                         const Progress& progress) {
  const DeformScene scene = parse_deform_scene(text.text(), named_file(file), false);
  const std::string topology_text = extract_topology_text(text.text());
  if (made_ && problem_.empty() && topology_text == topology_text_ && scene.mesh == scene_.mesh)
    solve(scene);
  else
    make(scene, topology_text, !made_ || !problem_.empty(), progress);
}

void EditedMesh::update_text(const SceneText& text, const std::filesystem::path& file) {
  scene_ = parse_deform_scene(text.text(), named_file(file), false);
  topology_text_ = extract_topology_text(text.text());
}

void EditedMesh::make(const DeformScene& scene, const std::string& topology_text, bool may_fail,
                      const Progress& progress) {
  progress.update("mesh", 0);
  const bool same_mesh = made_ && scene.mesh == scene_.mesh;
  auto made = std::make_unique<State>(
      scene,
      same_mesh ? made_->source : std::make_shared<const MeshSource>(read_source(scene.mesh)));
  std::string problem;
  try {
    progress.update("features", 0);
    made->solver.select().proposals();
    made->solver.solve(made->solver.scene(), progress);
  } catch (const CancelledError&) {
    throw;
  } catch (const Error& e) {
    if (!may_fail) throw;
    problem = e.what();
  }
  made->show();
  made_ = std::move(made);
  scene_ = scene;
  topology_text_ = topology_text;
  problem_ = problem;
}

void EditedMesh::solve(const DeformScene& scene) {
  made_->solver.solve(without_unfinished_edits(scene));
  scene_ = scene;
}

bool EditedMesh::moves(const std::string& parameter) const {
  if (!made_ || made_->solver.edits().empty()) return false;
  const EditSpec& last = made_->solver.edits().back()->rule();
  return std::any_of(last.handles.begin(), last.handles.end(), [&](const auto& handle) {
    return parameter.starts_with(last.name + "." + handle.name + ".");
  });
}

void EditedMesh::check(const std::string& parameter, double value) const {
  DeformScene(scene_).set(parameter, value, "");
}

void EditedMesh::set(const std::string& parameter, double value) {
  scene_.set(parameter, value, "");
}

double EditedMesh::value(const std::string& parameter) const {
  for (const Parameter& p : scene_.parameters())
    if (p.name == parameter) return p.value;
  for (const EditSpec& edit : scene_.edits)
    for (const auto& handle : edit.handles)
      for (int i = 0; i < 3; ++i)
        if (parameter == edit.name + "." + handle.name + ".rotation." + "xyz"[i])
          return handle.degrees * handle.axis[i];
  throw InputError("found no parameter '" + parameter + "'");
}

bool EditedMesh::solve_preview() {
  bool is_at_rest = true;
  apply_numbers([&](EditSession& last) {
    last.solve_preview();
    is_at_rest = last.is_at_rest();
  });
  return is_at_rest;
}

void EditedMesh::solve_to_equilibrium() {
  apply_numbers([](EditSession& last) { last.solve_to_equilibrium(); });
}

// If there is no solution for the new values, the last ones with a solution are restored.
template <class Function>
void EditedMesh::apply_numbers(const Function& go) {
  if (!made_ || made_->solver.edits().empty()) return;
  EditSession& last = *made_->solver.edits().back();
  const auto now = std::find_if(scene_.edits.begin(), scene_.edits.end(),
                                [&](const auto& rule) { return rule.name == last.rule().name; });
  const EditSpec before = last.rule();
  try {
    last.set(*now);
    go(last);
  } catch (const Error&) {
    last.set(before);
    *now = before;
    throw;
  }
}

bool EditedMesh::draw(Frame& frame) {
  if (!made_) return false;
  made_->display->draw(made_->solver.shape(), frame);
  return true;
}

const Points& EditedMesh::shape() const { return made_->solver.shape(); }
const MeshSource& EditedMesh::source() const { return *made_->source; }

std::string EditedMesh::rows() const {
  if (!problem_.empty()) return summary_line("mesh", "without edits: " + problem_);
  const ShellMesh& shells = made_->source->file.shells();
  return summary_line(
      "mesh", format_count(shells.node_count(), "node") + ", " +
                  format_count(shells.face_count(), "face") + ", " +
                  format_count(made_->solver.shared().features.size(), "feature") +
                  ", maximum displacement " +
                  format_number((shape() - made_->mesh().points()).rowwise().norm().maxCoeff()) +
                  " " + scene_.unit);
}

std::string EditedMesh::run(const std::filesystem::path& folder, const Progress& progress) {
  return sentence_lines(run_deform(scene_, folder, {}, progress).failed_checks);
}

std::string EditedMesh::export_shape(const std::filesystem::path& file, const Progress&) {
  const MeshFile& read = made_->source->file;
  const Points places = node_positions(shape(), read);
  if (lower_extension(file) == lower_extension(scene_.mesh)) {
    const MeshFile::Rounding written = read.write(file, places);
    std::string notes;
    if (written.largest > 1e-9 * made_->mesh().size())
      notes = "the number fields of this deck round coordinates by up to " +
              format_number(written.largest) + " " + scene_.unit + "\n";
    for (const std::string& note : written.notes) notes += note + "\n";
    return notes;
  }
  ShellMesh shells = read.shells();
  shells.points = places;
  write_mesh(file, shells, {}, unit_in_metres(scene_.unit));
  return "";
}

// Display data.

void EditedMesh::State::show() {
  std::vector<std::vector<int>> lines;
  const auto add_line = [&](std::vector<int> vertices, bool closed, const std::string& name) {
    if (closed && !vertices.empty()) vertices.push_back(vertices.front());
    lines.push_back(std::move(vertices));
    line_names.push_back(name);
  };
  for (const DetectedFeature& p : solver.select().proposals()) add_line(p.loop, true, p.name);
  for (const auto& loop : mesh().topology().boundary_loops())
    if (std::none_of(lines.begin(), lines.end(),
                     [&](const auto& line) { return line.front() == loop.front(); }))
      add_line(loop, true, "");
  for (const auto& line : solver.shared().lines) add_line(line, false, "");
  display = std::make_unique<const MeshDisplay>(mesh(), lines);

  auto seen = std::make_shared<MeshView>();
  const MeshTopology& topology = mesh().topology();
  points_of.assign(topology.node_count(), {});
  const std::vector<int>& vertices = display->vertices();
  for (int p = 0; p < isize(vertices); ++p) {
    const int node = topology.node_of(vertices[p]);
    points_of[node].push_back(p);
    seen->labels.push_back(source->file.node_label(node));
    for (const double x : mesh().point(vertices[p])) seen->rest.push_back(static_cast<float>(x));
  }
  show_parts(*seen);
  show_roles(*seen);
  view = std::move(seen);
}

std::vector<int> EditedMesh::State::points(const std::vector<int>& nodes) const {
  std::vector<int> all;
  for (const int v : nodes) {
    const auto& some = points_of[mesh().topology().node_of(v)];
    all.insert(all.end(), some.begin(), some.end());
  }
  return all;
}

void EditedMesh::State::show_parts(MeshView& seen) {
  for (const DetectedFeature& p : solver.select().proposals())
    seen.parts.push_back(
        {Part::Kind::Proposal, p.name, "", 2 * p.measure.equivalent_radius, points(p.vertices)});
  for (const SelectionSpec& rule : solver.scene().selections) try {
      seen.parts.push_back({Part::Kind::Selection, rule.name, "", 0,
                            points(solver.select().of({rule.name, rule.location}))});
    } catch (const InputError&) {
      continue;  // reported as the problem
    }
  for (const bool property : {false, true})
    for (const MeshSet& set : property ? source->file.properties() : source->file.sets()) {
      std::vector<int> nodes = set.nodes;
      for (const int f : set.faces) {
        const auto face = source->file.shells().face(f);
        nodes.insert(nodes.end(), face.begin(), face.end());
      }
      seen.parts.push_back({Part::Kind::Set, set.name, property ? "property" : "set", 0,
                            points(sorted_unique(std::move(nodes)))});
    }
}

void EditedMesh::State::show_roles(MeshView& seen) const {
  seen.roles.assign(display->vertices().size(), Role::Free);
  const auto mark = [&](const std::vector<int>& nodes, Role role) {
    for (const int p : points(nodes)) seen.roles[p] = role;
  };
  for (const FormFeature& f : solver.shared().features) mark(f.vertices, Role::Feature);
  if (solver.edits().empty()) return;
  mark(solver.edits().back()->task().problem.fixed, Role::Fixed);
  for (const Handle& h : solver.edits().back()->task().problem.handles)
    mark(h.vertices, Role::Handle);
}

void EditedMesh::fill_view(DocumentView& view) const {
  view.unit = scene_.unit;
  for (const Parameter& p : scene_.parameters())
    view.sliders.push_back({p.name, unit_of_move(p.name, view.unit), p.value, p.min, p.max, false});
  if (!made_) return;
  view.surface = true;
  view.triangles = made_->mesh().triangle_count();
  view.size = made_->mesh().size();
  view.regions = {scene_.mesh.filename().string()};
  view.shown_lines = made_->line_names;
  view.mesh = made_->view;
  for (const auto& edit : made_->solver.edits())
    for (size_t h = 0; h < edit->rule().handles.size(); ++h) {
      const auto& rule = edit->rule().handles[h];
      const Vec3 about = edit->task().edit.handles[h].about;
      view.handles.push_back({edit->rule().name + "." + rule.name, about + rule.translate,
                              rule.translate, rule.degrees * rule.axis,
                              edit == made_->solver.edits().back()});
    }
}

}  // namespace batten
