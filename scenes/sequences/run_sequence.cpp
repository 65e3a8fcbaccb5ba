// SPDX-License-Identifier: MPL-2.0
#include "batten/scenes/commands.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>
#include <utility>
#include <vector>

#include "batten/core/cancellation.h"
#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/io/files/command_files.h"
#include "batten/io/files/input_file.h"
#include "batten/io/files/text.h"
#include "batten/io/meshes/mesh_file.h"
#include "batten/io/pictures/image.h"
#include "batten/io/pictures/mesh_pictures.h"
#include "batten/mesh/sequence/mesh_sequence.h"
#include "batten/scenes/runs/run_support.h"
#include "batten/scenes/sequences/frame_store.h"
#include "batten/scenes/sequences/sequence_edits.h"

namespace batten {

// Contact sheets and animations of sequences.

/// Frames shown in pictures (0-based), of the sequence before and after. Of a long sequence only
/// these are in memory.
struct ShownFrames {
  std::vector<int> before, after;
};
ShownFrames shown_frames(const SequenceScene& scene, int before, int first, int last);

/// Draws the pictures of a scene. `after`: positions of shown.after, in the same order. Terrains of
/// footprint steps are drawn, too.
void draw_sequence(SequenceReport& report, const SequenceScene& scene,
                   const PreparedSequence& before, const SequenceParts& parts,
                   const ShellMesh& shells, const ShownFrames& shown,
                   const std::vector<Points>& after, const SequenceTask& task,
                   const OutputFolder& out);

namespace {

/// One run of `batten sequence`.
class SequenceRun {
 public:
  SequenceRun(const SequenceScene& scene, const std::filesystem::path& folder,
              const SequenceTask& task, const Progress& progress)
      : scene_(scene), task_(task), progress_(progress), out_(folder), watch_(report_.timings) {}

  SequenceReport operator()() {
    read();
    edits_->find_parts();
    watch_.lap("parts");
    require_replaceable();
    edits_->apply([&](const SequenceSource& source) { return read_source_frames(source); },
                  progress_);
    watch_.lap("operations");
    write_frames();
    draw();
    finish();
    return std::move(report_);
  }

 private:
  void read() {
    edits_.emplace(scene_, read_source_frames(scene_.source), report_);
    fingerprint_.add("batten " BATTEN_VERSION "\n" +
                     read_input_file(scene_.file, "a sequence scene (.toml)"));
    add_files(scene_.selections);
    for (const auto& step : scene_.steps) {
      if (const auto* feet = std::get_if<SequenceOperation::FootContacts>(&step.what))
        fingerprint_.add_file(feet->terrain);
      if (const auto* mix = std::get_if<SequenceOperation::Mix>(&step.what))
        add_files(mix->selections);
    }
    watch_.lap("read");
  }

  void add_files(const std::vector<SelectionSpec>& selections) {
    for (const SelectionSpec& rule : selections)
      if (!rule.file.empty()) fingerprint_.add_file(rule.file);
  }

  /// Reads the frames of a source, and adds them to the fingerprint. Exceptions contain the
  /// location in the scene.
  MeshSequence read_source_frames(const SequenceSource& source) {
    try {
      MeshSequence frames = read_frames(source.path, source.options, progress_);
      fingerprint_.add(frames);
      return frames;
    } catch (const InputError& e) {
      throw InputError(scene_.at(source.location) + e.what());
    }
  }

  void require_replaceable() const {
    std::vector<std::string> names{task_.name_of("report.json"), scene_.frames_out};
    for (const auto& rule : scene_.pictures) names.push_back(task_.name_of(rule.file));
    out_.require_replaceable(names);
  }

  void write_frames() {
    const int count = edits_->frame_count();
    const auto [first, last] = task_.frames.value_or(std::pair(1, count));
    if (first < 1 || last < first || last > count)
      throw InputError("found --frames " + std::to_string(first) + ":" + std::to_string(last) +
                       ", expected frames from 1 to " + std::to_string(count));
    report_.frames = count;
    report_.first = first;
    report_.last = last;
    const std::vector<double> times =
        written_times(scene_.frames_out, edits_->result().times, scene_.frames_per_second);
    FrameStore store(out_.folder(), out_.file(scene_.frames_out), scene_.frames_out,
                     edits_->result().shells, times, first - 1, last - 1, fingerprint_.text());
    shown_ = shown_frames(scene_, report_.frames_before, first - 1, last - 1);
    const auto look = [&](int k, const Points& p) {
      edits_->measure(k, p);
      if (std::binary_search(shown_.after.begin(), shown_.after.end(), k)) kept_.push_back(p);
    };
    // An old report does not belong to new frames.
    std::error_code none;
    for (int k = first - 1; k < last; ++k)
      if (!store.has(k)) {
        std::filesystem::remove(out_.folder() / task_.name_of("report.json"), none);
        break;
      }
    const DeferredFlush deferred;
    for (int k = first - 1; k < last;) {
      if (store.has(k)) {
        look(k, store.read(k));
        ++report_.found;
        ++k;
        continue;
      }
      int end = k;
      while (end + 1 < last && !store.has(end + 1)) ++end;
      const auto write = [&](int frame, const Points& p) {
        store.write(frame, p);
        look(frame, p);
      };
      edits_->make_frames(k, end, write, progress_);
      k = end + 1;
    }
    report_.files = store.finish();
    DeferredFlush::flush(out_.folder());
    edits_->finish_measures();
    watch_.lap("frames");
  }

  void draw() {
    draw_sequence(report_, scene_, edits_->input(), edits_->parts(), edits_->result().shells,
                  shown_, kept_, task_, out_);
    watch_.lap("pictures");
  }

  void finish() {
    watch_.total();
    write_report(report_, edits_->failed_checks(), out_, progress_, task_.name_of("report.json"));
    out_.commit(task_.name_of("report.json"));
  }

  const SequenceScene& scene_;
  const SequenceTask& task_;
  const Progress& progress_;
  OutputFolder out_;
  SequenceReport report_;
  Stopwatch watch_;
  Fingerprint fingerprint_;
  std::optional<SequenceEdits> edits_;
  ShownFrames shown_;
  std::vector<Points> kept_;
};

}  // namespace

SequenceReport run_sequence(const SequenceScene& scene, const std::filesystem::path& folder,
                            const SequenceTask& task, const Progress& progress) {
  const ProgressScope scope(progress);
  const CommandFiles files;
  record_input(scene.file);
  return SequenceRun(scene, folder, task, progress)();
}

std::string SequenceTask::name_of(const std::filesystem::path& file) const {
  if (!frames) return file.string();
  std::filesystem::path name = file;
  name.replace_filename(file.stem().string() + "_" + std::to_string(frames->first) + "-" +
                        std::to_string(frames->second) + file.extension().string());
  return name.string();
}

namespace {

/// Selects `count` evenly spaced frames of a range, including both ends; 0: all.
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

/// A mesh and its surroundings, as one mesh for pictures.
struct SceneGeometry {
  ShellMesh shells;
  std::vector<MeshPicture::Part> parts;
  Points ground;      // additional nodes
  int own_faces = 0;  // number of faces before those of the ground

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

/// Data of all pictures of a run.
struct SequenceDrawing {
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
  look.title = rule.title;
  return look;
}

/// One picture per frame, all at the same scale.
std::vector<MeshPicture> one_by_one(const SequenceDrawing& d, const SequencePicture& rule,
                                    bool is_after, bool numbered) {
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

/// All frames in one picture. `shells`: storage for its mesh.
MeshPicture all_together(const SequenceDrawing& d, const SequencePicture& rule, bool is_after,
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
  const int shift = nodes * (isize(places) - 1);  // index offset of the ground, which occurs once
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

void animate(const SequenceDrawing& d, const SequencePicture& rule,
             const std::filesystem::path& path) {
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

void draw_sheet(const SequenceDrawing& d, const SequencePicture& rule,
                const std::filesystem::path& path) {
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
  SequenceDrawing drawing{report, scene, geometry, shown, {}, after};
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

namespace {

/// Abbreviates numbered frames by the first and the last one.
std::vector<std::string> in_short(const std::vector<std::string>& files) {
  std::vector<std::string> text;
  const auto alike = [&](size_t a, size_t b) {
    const std::filesystem::path p = files[a], q = files[b];
    return p.parent_path() == q.parent_path() && p.extension() == q.extension();
  };
  for (size_t from = 0; from < files.size();) {
    size_t to = from;
    while (to + 1 < files.size() && alike(from, to + 1)) ++to;
    if (to - from < 4) {
      text.insert(text.end(), files.begin() + static_cast<long>(from),
                  files.begin() + static_cast<long>(to) + 1);
    } else {
      text.push_back(files[from] + " … " + files[to] + " (" + std::to_string(to - from + 1) +
                     " files)");
    }
    from = to + 1;
  }
  return text;
}

}  // namespace

std::string summary(const SequenceReport& report, const std::filesystem::path& folder) {
  std::string text = printable(report.name) + "\n";
  text += summary_line("sequence", std::to_string(report.frames_before) + " frames, " +
                                       std::to_string(report.nodes) + " nodes, " +
                                       std::to_string(report.faces) + " faces");
  for (const auto& s : report.steps)
    text += summary_line("operation", s.name + " (" + s.kind + "): " + std::to_string(s.frames) +
                                          " frames, " + format_count(s.keyframes, "keyframe") +
                                          ", " + format_number(s.seconds) + " s");
  text += summary_line(
      "frames",
      std::to_string(report.first) + " to " + std::to_string(report.last) + " of " +
          std::to_string(report.frames) +
          (report.found > 0 ? ", " + std::to_string(report.found) + " of them from an earlier run"
                            : ""));
  if (!report.feet.empty()) {
    double before = 0, after = 0;
    for (const auto& f : report.feet) {
      before = std::max(before, f.foot_skate_before);
      after = std::max(after, f.foot_skate);
    }
    text += summary_line("foot plants", std::to_string(report.feet.size()) + ", foot skate " +
                                            format_number(before) + " -> " + format_number(after) +
                                            " of the size");
  }
  double rigid = 0;
  for (const auto& f : report.features) rigid = std::max(rigid, f.max_rigid_error);
  if (!report.features.empty())
    text += summary_line("features", std::to_string(report.features.size()) + ", rigid to " +
                                         format_number(rigid) + " of their size");
  text += summary_line(
      "smoothness", "largest second difference " + format_number(report.second_difference_before) +
                        " -> " + format_number(report.second_difference) + " " + report.unit +
                        ", inverted triangles " + std::to_string(report.inverted_triangles_before) +
                        " -> " + std::to_string(report.inverted_triangles));
  RunReport shown = report;
  shown.files = in_short(report.files);
  return text + summary_footer(shown, folder);
}

}  // namespace batten
