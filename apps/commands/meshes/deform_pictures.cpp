#include "batten/apps/commands/meshes/deform_pictures.h"

#include <cmath>

#include "batten/apps/commands/meshes/mesh_source.h"
#include "batten/io/pictures/mesh_pictures.h"

namespace batten {
namespace {

std::vector<MeshPicture::Part> parts_of(const ShellMesh& shells, const SharedConstraints& shared,
                                        const DeformTask& task) {
  std::vector<MeshPicture::Part> vertex(shells.node_count(), MeshPicture::Part::Body);
  for (const int v : task.problem.fixed) vertex[v] = MeshPicture::Part::Fixed;
  for (const auto& h : task.problem.handles)
    for (const int v : h.vertices) vertex[v] = MeshPicture::Part::Handle;
  for (const auto& f : shared.features)
    for (const int v : f.vertices) vertex[v] = MeshPicture::Part::Feature;
  return parts_of_faces(shells, vertex);
}

}  // namespace

void draw_deformed(DeformReport& report, const DeformScene& scene, const MeshFile& file,
                   const std::vector<Points>& states, const std::vector<DeformTask>& tasks,
                   const SharedConstraints& shared, const OutputFolder& out) {
  if (scene.pictures.empty()) return;
  using Show = MeshPictureSpec::Show;
  const auto parts = parts_of(file.shells(), shared, tasks.front());
  std::vector<Points> places;
  for (const Points& state : states) places.push_back(node_positions(state, file));
  for (const MeshPictureSpec& rule : scene.pictures) {
    if (!can_draw(report, rule.file)) continue;
    MeshPicture look;
    look.shells = &file.shells();
    look.parts = parts;
    look.lines = shared.lines;
    look.mesh = rule.mesh;
    look.azimuth = rule.azimuth;
    look.elevation = rule.elevation;
    look.up = rule.up;
    look.zoom = rule.zoom;
    for (const Points& state : places) look.also_in_view.push_back(&state);
    std::vector<MeshPicture> pictures;
    const auto add = [&](size_t state, const std::string& title) {
      look.points = places[state];
      look.title = title;
      pictures.push_back(look);
    };
    const std::string name = rule.title.empty() ? scene.name : rule.title;
    int columns = 1;
    if (rule.show == Show::BeforeAfter) {
      add(0, name + ", before");
      add(states.size() - 1, name + ", after");
      columns = 2;
    } else if (rule.show == Show::Steps) {
      add(0, name + ", before");
      for (size_t k = 1; k < states.size(); ++k) add(k, scene.edits[k - 1].name);
      columns = static_cast<int>(std::ceil(std::sqrt(static_cast<double>(states.size()))));
    } else {
      if (rule.show == Show::Displacement) {
        look.field = (places.back() - places.front()).rowwise().norm();
        look.field_title = "Displacement, " + scene.unit;
      }
      look.also_in_view.clear();
      add(states.size() - 1, name);
    }
    draw_meshes(out.file(rule.file), pictures, columns, rule.size);
    report.files.push_back(rule.file);
  }
}

}  // namespace batten
