#include "batten/apps/commands/sequences/sequence_pictures.h"

#include <algorithm>
#include <cmath>

#include "batten/core/sorted_unique.h"
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
struct SceneGeometry {
  ShellMesh shells;
  std::vector<MeshPicture::Part> parts;
  Points ground;      // further nodes
  int own_faces = 0;  // those before the ground's

  Points with_ground(const Points& frame) const {
    Points all(frame.rows() + ground.rows(), 3);
    all << frame, ground;
    return all;
  }
};

SceneGeometry stage_for(const SequenceScene& scene, const ShellMesh& shells,
                        const SequenceParts& parts) {
  SceneGeometry geometry;
  geometry.shells = shells;
  std::vector<MeshPicture::Part> node(shells.node_count(), MeshPicture::Part::Body);
  for (const auto& h : parts.handles)
    for (const int v : h.vertices) node[v] = MeshPicture::Part::Handle;
  for (const auto& f : parts.features)
    for (const int v : f.vertices) node[v] = MeshPicture::Part::Feature;
  geometry.parts = parts_of_faces(shells, node);
  geometry.own_faces = shells.face_count();
  geometry.ground.resize(0, 3);
  for (const auto& step : scene.steps) {
    const auto* feet = std::get_if<SequenceOperation::FootContacts>(&step.what);
    if (!feet || feet->terrain.empty()) continue;
    const ShellMesh terrain = MeshFile::read(feet->terrain).shells();
    const auto from = static_cast<int>(shells.node_count() + geometry.ground.rows());
    Points ground(geometry.ground.rows() + terrain.node_count(), 3);
    ground << geometry.ground, terrain.points;
    geometry.ground = std::move(ground);
    for (int f = 0; f < terrain.face_count(); ++f) {
      std::vector<int> face(terrain.corners(f).begin(), terrain.corners(f).end());
      for (int& v : face) v += from;
      geometry.shells.add_face(face);
      geometry.parts.push_back(MeshPicture::Part::Fixed);
    }
  }
  geometry.shells.points = geometry.with_ground(shells.points);
  return geometry;
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
  shown.before = sorted_unique(std::move(shown.before));
  shown.after = sorted_unique(std::move(shown.after));
  return shown;
}

namespace {

/// What all pictures of one run are drawn from.
struct Drawing {
  const SequenceReport& report;
  const SequenceScene& scene;
  const SceneGeometry& geometry;
  const ShownFrames& shown;
  std::vector<Points> before, after;  // nodes of the sequence only

  const Points& at(bool is_after, int frame) const {
    const auto& list = is_after ? shown.after : shown.before;
    return (is_after ? after
                     : before)[std::lower_bound(list.begin(), list.end(), frame) - list.begin()];
  }
  std::vector<int> frames(const SequencePicture& rule, bool is_after) const {
    return is_after ? spread(report.first - 1, report.last - 1, rule.frames)
                    : spread(0, report.frames_before - 1, rule.frames);
  }
};

MeshPicture picture_settings(const SequenceScene& scene, const SequencePicture& rule) {
  MeshPicture look;
  look.mesh = rule.mesh;
  look.azimuth = rule.azimuth;
  look.elevation = rule.elevation;
  look.zoom = rule.zoom;
  look.up = scene.up;
  look.title = rule.title.empty() ? scene.name : rule.title;
  return look;
}

/// One picture for each frame, all of one scale.
std::vector<MeshPicture> one_by_one(const Drawing& d, const SequencePicture& rule, bool is_after,
                                    bool numbered) {
  std::vector<MeshPicture> pictures;
  for (const int k : d.frames(rule, is_after)) {
    MeshPicture look = picture_settings(d.scene, rule);
    look.shells = &d.geometry.shells;
    look.parts = d.geometry.parts;
    look.points = d.geometry.with_ground(d.at(is_after, k));
    if (numbered) look.title = (is_after ? "after, " : "before, ") + std::to_string(k + 1);
    pictures.push_back(std::move(look));
  }
  return pictures;
}

/// All frames in one picture. `shells`: where its mesh is kept.
MeshPicture all_together(const Drawing& d, const SequencePicture& rule, bool is_after,
                         ShellMesh& shells) {
  MeshPicture look = picture_settings(d.scene, rule);
  if (rule.show == SequencePicture::Show::Both) look.title = is_after ? "after" : "before";
  const auto nodes = static_cast<int>(d.at(is_after, d.frames(rule, is_after)[0]).rows());
  std::vector<Points> places;
  for (const int k : d.frames(rule, is_after)) {
    const int shift = nodes * isize(places);
    places.push_back(d.at(is_after, k));
    for (int f = 0; f < d.geometry.own_faces; ++f) {
      std::vector<int> face(d.geometry.shells.corners(f).begin(),
                            d.geometry.shells.corners(f).end());
      for (int& v : face) v += shift;
      shells.add_face(face);
      look.parts.push_back(d.geometry.parts[f]);
    }
  }
  const int shift = nodes * (isize(places) - 1);  // of the ground, which is there once
  for (int f = d.geometry.own_faces; f < d.geometry.shells.face_count(); ++f) {
    std::vector<int> face(d.geometry.shells.corners(f).begin(), d.geometry.shells.corners(f).end());
    for (int& v : face) v += shift;
    shells.add_face(face);
    look.parts.push_back(d.geometry.parts[f]);
  }
  look.points.resize(static_cast<long>(nodes) * isize(places) + d.geometry.ground.rows(), 3);
  for (size_t k = 0; k < places.size(); ++k)
    look.points.middleRows(static_cast<long>(k) * nodes, nodes) = places[k];
  look.points.bottomRows(d.geometry.ground.rows()) = d.geometry.ground;
  shells.points = look.points;
  look.shells = &shells;
  return look;
}

void animate(const Drawing& d, const SequencePicture& rule, const std::filesystem::path& path) {
  using Show = SequencePicture::Show;
  std::vector<MeshPicture> left, right;
  if (rule.show != Show::After) left = one_by_one(d, rule, false, false);
  if (rule.show != Show::Before) right = one_by_one(d, rule, true, false);
  std::vector<const Points*> in_view;
  for (const auto* list : {&left, &right})
    for (const auto& picture : *list) in_view.push_back(&picture.points);
  std::vector<Image> images;
  for (size_t k = 0; k < std::max(left.size(), right.size()); ++k) {
    std::vector<MeshPicture> one;
    if (!left.empty()) one.push_back(left[std::min(k, left.size() - 1)]);
    if (!right.empty()) one.push_back(right[std::min(k, right.size() - 1)]);
    for (auto& picture : one) picture.also_in_view = in_view;
    images.push_back(mesh_image(one, isize(one), rule.size));
  }
  write_gif(path, images, rule.seconds, rule.seconds);
}

void draw_sheet(const Drawing& d, const SequencePicture& rule, const std::filesystem::path& path) {
  using Show = SequencePicture::Show;
  std::vector<MeshPicture> pictures;
  ShellMesh shells[2];
  int columns = 1;
  for (const bool is_after : {false, true}) {
    if (rule.show == (is_after ? Show::Before : Show::After)) continue;
    if (rule.together) {
      pictures.push_back(all_together(d, rule, is_after, shells[is_after]));
      continue;
    }
    auto row = one_by_one(d, rule, is_after, true);
    columns = rule.show == Show::Both ? std::max(columns, isize(row))
                                      : static_cast<int>(std::ceil(std::sqrt(row.size())));
    std::move(row.begin(), row.end(), std::back_inserter(pictures));
  }
  if (!rule.together) {
    std::vector<Points> places;
    for (const auto& picture : pictures) places.push_back(picture.points);
    for (auto& picture : pictures)
      for (const Points& p : places) picture.also_in_view.push_back(&p);
    draw_meshes(path, pictures, columns, rule.size);
  } else {
    draw_meshes(path, pictures, columns, rule.size);
  }
}

}  // namespace

void draw_sequence(SequenceReport& report, const SequenceScene& scene,
                   const PreparedSequence& before, const SequenceParts& parts,
                   const ShellMesh& shells, const ShownFrames& shown,
                   const std::vector<Points>& after, const SequenceTask& task,
                   const OutputFolder& out) {
  if (scene.pictures.empty()) return;
  const SceneGeometry geometry = stage_for(scene, shells, parts);
  Drawing drawing{report, scene, geometry, shown, {}, after};
  for (const int k : shown.before) drawing.before.push_back(before.sequence.frames[k]);
  for (const SequencePicture& rule : scene.pictures) {
    const std::string file = task.name_of(rule.file);
    if (!can_draw(report, file)) continue;
    if (file.ends_with(".gif"))
      animate(drawing, rule, out.file(file));
    else
      draw_sheet(drawing, rule, out.file(file));
    report.files.push_back(file);
  }
}

}  // namespace batten
