#include "batten/apps/commands/sequences/sequence_pictures.h"

#include <algorithm>
#include <cmath>

#include "batten/core/each_once.h"
#include "batten/io/meshes/mesh_file.h"
#include "batten/io/pictures/animation.h"
#include "batten/io/pictures/mesh_pictures.h"

namespace batten {
namespace {

/// So many frames of a range, evenly, with both ends; 0: all.
std::vector<int> spread(int first, int last, int count) {
  std::vector<int> frames;
  const int all = last - first + 1;
  if (count == 0 || count > all) count = all;
  for (int k = 0; k < count; ++k)
    frames.push_back(first + (count > 1 ? static_cast<int>(std::lround(static_cast<double>(k) *
                                                                       (all - 1) / (count - 1)))
                                        : 0));
  return frames;
}

/// A mesh and what stands around it, as one mesh for pictures.
struct Stage {
  ShellMesh shells;
  std::vector<MeshPicture::Part> parts;
  Points ground;  // further nodes

  Points with_ground(const Points& frame) const {
    Points all(frame.rows() + ground.rows(), 3);
    all << frame, ground;
    return all;
  }
};

Stage stage_for(const SequenceScene& scene, const ShellMesh& shells, const SequenceParts& parts) {
  Stage stage;
  stage.shells = shells;
  std::vector<MeshPicture::Part> node(shells.node_count(), MeshPicture::Part::Body);
  for (const auto& h : parts.handles)
    for (const int v : h.vertices) node[v] = MeshPicture::Part::Handle;
  for (const auto& f : parts.features)
    for (const int v : f.vertices) node[v] = MeshPicture::Part::Feature;
  for (int f = 0; f < shells.face_count(); ++f) {
    const auto face = shells.face(f);
    const auto part = node[face[0]];
    const bool same = std::all_of(face.begin(), face.end(), [&](int v) { return node[v] == part; });
    stage.parts.push_back(same ? part : MeshPicture::Part::Body);
  }
  stage.ground.resize(0, 3);
  for (const auto& step : scene.steps) {
    const auto* feet = std::get_if<SequenceStep::Footprints>(&step.what);
    if (!feet || feet->terrain.empty()) continue;
    const ShellMesh terrain = MeshFile::read(feet->terrain).shells();
    const auto from = static_cast<int>(shells.node_count() + stage.ground.rows());
    Points ground(stage.ground.rows() + terrain.node_count(), 3);
    ground << stage.ground, terrain.points;
    stage.ground = std::move(ground);
    for (int f = 0; f < terrain.face_count(); ++f) {
      std::vector<int> face(terrain.corners(f).begin(), terrain.corners(f).end());
      for (int& v : face) v += from;
      stage.shells.add_face(face);
      stage.parts.push_back(MeshPicture::Part::Fixed);
    }
  }
  stage.shells.points = stage.with_ground(shells.points);
  return stage;
}

}  // namespace

ShownFrames shown_frames(const SequenceScene& scene, int before, int first, int last) {
  ShownFrames shown;
  using Show = SequencePicture::Show;
  for (const auto& picture : scene.pictures) {
    const auto add = [&](std::vector<int>& list, const std::vector<int>& more) {
      list.insert(list.end(), more.begin(), more.end());
    };
    if (picture.show != Show::After) add(shown.before, spread(0, before - 1, picture.frames));
    if (picture.show != Show::Before) add(shown.after, spread(first, last, picture.frames));
  }
  shown.before = each_once(std::move(shown.before));
  shown.after = each_once(std::move(shown.after));
  return shown;
}

void draw_sequence(SequenceReport& report, const SequenceScene& scene,
                   const PreparedSequence& before, const SequenceParts& parts,
                   const ShellMesh& shells, const ShownFrames& shown,
                   const std::vector<Points>& after, const OutputFolder& out) {
  if (scene.pictures.empty()) return;
  using Show = SequencePicture::Show;
  const Stage stage = stage_for(scene, shells, parts);
  std::vector<Points> places_before, places_after;
  for (const int k : shown.before)
    places_before.push_back(stage.with_ground(before.sequence.frames[k]));
  for (const Points& p : after) places_after.push_back(stage.with_ground(p));
  const auto place_of = [](const std::vector<int>& list, int frame) {
    return std::lower_bound(list.begin(), list.end(), frame) - list.begin();
  };
  for (const SequencePicture& rule : scene.pictures) {
    if (!can_draw(report, rule.file)) continue;
    MeshPicture look;
    look.shells = &stage.shells;
    look.parts = stage.parts;
    look.mesh = rule.mesh;
    look.azimuth = rule.azimuth;
    look.elevation = rule.elevation;
    look.zoom = rule.zoom;
    look.up = scene.up;
    if (rule.show != Show::After)
      for (const Points& p : places_before) look.also_in_view.push_back(&p);
    if (rule.show != Show::Before)
      for (const Points& p : places_after) look.also_in_view.push_back(&p);
    const std::string name = rule.title.empty() ? scene.name : rule.title;
    const bool animated = rule.file.ends_with(".gif");
    const auto row = [&](bool is_after) {
      std::vector<MeshPicture> pictures;
      const auto frames = is_after ? spread(report.first - 1, report.last - 1, rule.frames)
                                   : spread(0, report.frames_before - 1, rule.frames);
      for (const int k : frames) {
        look.points = is_after ? places_after[place_of(shown.after, k)]
                               : places_before[place_of(shown.before, k)];
        look.title = animated ? name : (is_after ? "after, " : "before, ") + std::to_string(k + 1);
        pictures.push_back(look);
      }
      return pictures;
    };
    std::vector<MeshPicture> top, bottom;
    if (rule.show != Show::After) top = row(false);
    if (rule.show != Show::Before) bottom = row(true);
    if (animated) {
      std::vector<Image> images;
      for (size_t k = 0; k < std::max(top.size(), bottom.size()); ++k) {
        std::vector<MeshPicture> one;
        if (!top.empty()) one.push_back(top[std::min(k, top.size() - 1)]);
        if (!bottom.empty()) one.push_back(bottom[std::min(k, bottom.size() - 1)]);
        images.push_back(mesh_image(one, 2, rule.size));
      }
      write_gif(out.file(rule.file), images, rule.seconds, rule.seconds);
    } else {
      const int columns = count_of(top.empty() ? bottom : top);
      top.insert(top.end(), bottom.begin(), bottom.end());
      draw_meshes(out.file(rule.file), top, columns, rule.size);
    }
    report.files.push_back(rule.file);
  }
}

}  // namespace batten
