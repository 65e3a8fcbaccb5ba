#include "batten/scenes/commands.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>
#include <utility>
#include <vector>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/io/files/input_file.h"
#include "batten/io/files/text.h"
#include "batten/io/meshes/mesh_file.h"
#include "batten/io/pictures/image.h"
#include "batten/io/pictures/mesh_pictures.h"
#include "batten/mesh/rotation_fitting.h"
#include "batten/mesh/sequence/mesh_sequence.h"
#include "batten/scenes/runs/run_support.h"
#include "batten/scenes/sequences/frame_store.h"
#include "batten/scenes/sequences/sequence_steps.h"

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

// Measurements of the output frames.

/// Largest deviation of features and handles from a rigid-body motion by a step, over all frames.
class PartDeviation {
 public:
  explicit PartDeviation(const SequenceParts& parts)
      : features(parts.features.size(), 0), handles(parts.handles.size(), 0) {}
  /// Adds one frame: its positions before and after the step.
  void measure(const SequenceParts& parts, const Points& before, const Points& after);

  std::vector<double> features, handles;  ///< largest errors, relative to each part's size
};

template <class Part>
void measure_parts(const std::vector<Part>& parts, const Points& before, const Points& after,
                   std::vector<double>& largest) {
  for (size_t k = 0; k < parts.size(); ++k)
    largest[k] =
        std::max(largest[k], fit_similarity(before, after, parts[k].vertices, 1.0).max_error);
}

void PartDeviation::measure(const SequenceParts& parts, const Points& before, const Points& after) {
  measure_parts(parts.features, before, after, features);
  measure_parts(parts.handles, before, after, handles);
}

/// The nodes and frames of planted feet, for FrameMeasures.
std::vector<FrameMeasures::Foot> measured_feet(const SequenceParts& parts,
                                               const std::vector<SequenceReport::Foot>& feet) {
  std::vector<FrameMeasures::Foot> measured;
  for (const SequenceReport::Foot& foot : feet) {
    const auto h = std::ranges::find(parts.handles, foot.handle, &Handle::name);
    if (h == parts.handles.end()) throw std::logic_error("a foot that is no handle");
    measured.push_back({h->vertices, foot.first - 1, foot.last - 1});
  }
  return measured;
}

/// Stores all measurements in the report. `feet`: those that `measures` measured. `size`: of the
/// first frame.
void report_measures(const FrameMeasures& measures, const SequenceParts& parts,
                     const PartDeviation& deviation, std::vector<SequenceReport::Foot> feet,
                     double size, SequenceReport& report) {
  report.second_difference = measures.max_second_difference();
  report.inverted_triangles = measures.inverted_triangles();
  for (size_t h = 0; h < parts.handles.size(); ++h)
    report.handles.push_back(
        {parts.handles[h].name, isize(parts.handles[h].vertices), deviation.handles[h]});
  for (size_t f = 0; f < parts.features.size(); ++f)
    report.features.push_back(
        {parts.features[f].name, isize(parts.features[f].vertices), deviation.features[f]});
  for (int f = 0; f < isize(feet); ++f)
    feet[f].foot_skate = std::max(feet[f].foot_skate, measures.foot_skate(f) / size);
  report.feet = std::move(feet);
}

/// True if each frame after a step corresponds to the input frame with the same number. Exceptions:
/// root motion, which deforms nothing, and a morph, which deforms everything.
bool keeps_frames(const SequenceOperation& step) {
  return !std::holds_alternative<SequenceOperation::RootMotion>(step.what) &&
         !std::holds_alternative<SequenceOperation::Morph>(step.what);
}

/// One run of `batten sequence`.
class SequenceRun {
 public:
  SequenceRun(const SequenceScene& scene, const std::filesystem::path& folder,
              const SequenceTask& task, const Progress& progress)
      : scene_(scene), task_(task), progress_(progress), out_(folder), watch_(report_.timings) {}

  SequenceReport operator()() {
    read();
    find_parts();
    require_input_preserved();
    apply_steps();
    write_frames();
    draw();
    finish();
    return std::move(report_);
  }

 private:
  void read() {
    report_.name = scene_.name;
    report_.unit = scene_.unit;
    current_ = std::make_shared<const PreparedSequence>(prepared_sequence(
        read_frames(scene_.source), scene_.at(scene_.source.location), report_.warnings));
    input_ = current_;
    const MeshSequence& s = current_->sequence;
    report_.file = scene_.source.path.filename().string();
    report_.frames_before = s.frame_count();
    report_.nodes = s.node_count();
    report_.faces = s.shells.face_count();
    report_.size = size_of(s);
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
  MeshSequence read_frames(const SequenceSource& source) {
    try {
      MeshSequence frames = read_sequence(source.path, source.options, progress_);
      fingerprint_.add(frames);
      return frames;
    } catch (const InputError& e) {
      throw InputError(scene_.at(source.location) + e.what());
    }
  }

  void find_parts() {
    file_.emplace(MeshFile::from_shells(input_->sequence.shells));
    select_.emplace(scene_, *file_, input_->mesh);
    parts_ = find_sequence_parts(scene_, *select_);
    watch_.lap("parts");
  }

  /// Checks that a single output file does not overwrite the input.
  void require_input_preserved() const {
    std::filesystem::path out = out_.folder() / scene_.frames_out;
    const auto& source = scene_.source;
    std::error_code ignored;
    for (const auto& file : {out, std::filesystem::path(out).replace_extension(".obj")})
      for (const auto& input : {source.path, source.options.mesh,
                                std::filesystem::path(source.path).replace_extension(".obj")})
        if (std::filesystem::is_regular_file(file, ignored) &&
            std::filesystem::equivalent(file, input, ignored))
          throw InputError(
              file.string() +
              ": the frames would overwrite the input, expected another folder or name");
  }

  void apply_steps() {
    last_ = unchanged_result(current_);
    deviation_.emplace(parts_);
    for (size_t k = 0; k < scene_.steps.size(); ++k) {
      if (k > 0) {
        const auto before = std::exchange(current_, collect_frames(last_, input_->mesh, progress_));
        for (size_t f = 0; keeps_frames(scene_.steps[k - 1]) && f < before->sequence.frames.size();
             ++f)
          deviation_->measure(parts_, before->sequence.frames[f], current_->sequence.frames[f]);
      }
      const auto start = std::chrono::steady_clock::now();
      last_ = step(scene_.steps[k]);
      last_.report.seconds = seconds_since(start);
      report_.steps.push_back(last_.report);
      for (const auto& w : last_.warnings) report_.warnings.push_back(last_.report.name + ": " + w);
      for (const auto& foot : last_.feet)
        if (foot.foot_skate_before > 0.05)
          report_.warnings.push_back(
              last_.report.name + ": the foot '" + foot.handle + "' is planted in frames " +
              std::to_string(foot.first) + " to " + std::to_string(foot.last) +
              ", but moves there by " + format_number(foot.foot_skate_before) +
              " of the size: use a smaller distance in contact_detection = { distance = … }");
      if (last_.report.unconverged_keyframes > 0)
        report_.warnings.push_back(
            last_.report.name + ": " + std::to_string(last_.report.unconverged_keyframes) + " of " +
            std::to_string(last_.report.keyframes) + " keyframes did not converge in " +
            std::to_string(last_.report.iterations) + " iterations: the last change was " +
            format_number(last_.report.last_change) +
            " of the size; allow more with iterations = …");
    }
    watch_.lap("operations");
  }

  StepResult step(const SequenceOperation& rule) {
    const FrameReader read = [&](const SequenceSource& source) { return read_frames(source); };
    return run_step(scene_, rule, *current_, parts_, *select_, read, progress_);
  }

  /// Times of the output; glTF requires seconds.
  std::vector<double> written_times() const {
    std::vector<double> times = last_.times;
    const bool numbered =
        std::all_of(times.begin(), times.end(), [](double t) { return t == std::floor(t); });
    if (lower_extension(scene_.frames_out) == ".glb" && numbered)
      for (double& t : times) t = (t - last_.times.front()) / scene_.frames_per_second;
    return times;
  }

  /// Computes frames of the last step.
  void make_frames(int first, int last, const std::function<void(int, const Points&)>& take) const {
    if (scene_.steps.empty())
      last_.frames(first, last, take, progress_);
    else
      with_step_context(scene_, scene_.steps.back(),
                        [&] { last_.frames(first, last, take, progress_); });
  }

  void write_frames() {
    const int count = isize(last_.times);
    const auto [first, last] = task_.frames.value_or(std::pair(1, count));
    if (first < 1 || last < first || last > count)
      throw InputError("found --frames " + std::to_string(first) + ":" + std::to_string(last) +
                       ", expected frames from 1 to " + std::to_string(count));
    report_.frames = count;
    report_.first = first;
    report_.last = last;
    FrameStore store(out_.folder(), out_.file(scene_.frames_out), scene_.frames_out, last_.shells,
                     written_times(), first - 1, last - 1, fingerprint_.text());
    shown_ = shown_frames(scene_, report_.frames_before, first - 1, last - 1);
    FrameMeasures measures(input_->mesh, measured_feet(parts_, last_.feet));
    const auto look = [&](int k, const Points& p) {
      measures.add(k, p);
      if (!scene_.steps.empty() && keeps_frames(scene_.steps.back()))
        deviation_->measure(parts_, current_->sequence.frames[k], p);
      if (std::binary_search(shown_.after.begin(), shown_.after.end(), k)) kept_.push_back(p);
    };
    for (int k = first - 1; k < last;) {
      if (store.has(k)) {
        look(k, store.read(k));
        ++report_.found;
        ++k;
        continue;
      }
      int end = k;
      while (end + 1 < last && !store.has(end + 1)) ++end;
      make_frames(k, end, [&](int frame, const Points& p) {
        store.write(frame, p);
        look(frame, p);
      });
      k = end + 1;
    }
    report_.files = store.finish();
    report_measures(measures, parts_, *deviation_, last_.feet, report_.size, report_);
    FrameMeasures before(input_->mesh);
    for (int k = 0; k < report_.frames_before; ++k) before.add(k, input_->sequence.frames[k]);
    report_.second_difference_before = before.max_second_difference();
    report_.inverted_triangles_before = before.inverted_triangles();
    watch_.lap("frames");
  }

  void draw() {
    draw_sequence(report_, scene_, *input_, parts_, last_.shells, shown_, kept_, task_, out_);
    watch_.lap("pictures");
  }

  std::vector<FailedCheck> failed_checks() const {
    std::vector<FailedCheck> failed_checks;
    for (const auto& f : report_.features)
      if (!(f.max_rigid_error <= 1e-10))
        failed_checks.push_back({"features." + f.name, "is deformed by " +
                                                           format_number(f.max_rigid_error) +
                                                           " of its size, expected at most 1e-10"});
    for (const auto& f : report_.feet)
      if (!(f.foot_skate <= f.max_foot_skate))
        failed_checks.push_back({"foot_plants." + f.handle,
                                 "slips by " + format_number(f.foot_skate) +
                                     " of the size in frames " + std::to_string(f.first) + " to " +
                                     std::to_string(f.last) + ", expected at most " +
                                     format_number(f.max_foot_skate)});
    return failed_checks;
  }

  void finish() {
    watch_.total();
    write_report(report_, failed_checks(), out_, progress_, task_.name_of("report.json"));
    out_.commit();
  }

  const SequenceScene& scene_;
  const SequenceTask& task_;
  const Progress& progress_;
  OutputFolder out_;
  SequenceReport report_;
  Stopwatch watch_;
  Fingerprint fingerprint_;
  std::shared_ptr<const PreparedSequence> input_, current_;
  std::optional<MeshFile> file_;
  std::optional<VertexSelector> select_;
  SequenceParts parts_;
  std::optional<PartDeviation> deviation_;
  StepResult last_;
  ShownFrames shown_;
  std::vector<Points> kept_;
};

}  // namespace

SequenceReport run_sequence(const SequenceScene& scene, const std::filesystem::path& folder,
                            const SequenceTask& task, const Progress& progress) {
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
  look.title = rule.title.empty() ? scene.name : rule.title;
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
  std::string text = report.name + "\n";
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
