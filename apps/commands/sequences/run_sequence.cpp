#include "batten/apps/commands/sequences/run_sequence.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <deque>
#include <utility>

#include "batten/apps/commands/meshes/vertex_selector.h"
#include "batten/apps/commands/runs/run_parts.h"
#include "batten/apps/commands/sequences/frame_store.h"
#include "batten/apps/commands/sequences/sequence_pictures.h"
#include "batten/apps/commands/sequences/sequence_steps.h"
#include "batten/core/errors.h"
#include "batten/io/files/input_file.h"
#include "batten/io/files/text.h"
#include "batten/mesh/deform/similarity.h"

namespace batten {
namespace {

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// How far parts are from what they were before a step, in any frame.
struct Bent {
  explicit Bent(const SequenceParts& parts)
      : features(parts.features.size(), 0), handles(parts.handles.size(), 0) {}

  void measure(const SequenceParts& parts, const Points& before, const Points& after) {
    measure(parts.features, before, after, features);
    measure(parts.handles, before, after, handles);
  }

  std::vector<double> features, handles;  // largest errors

 private:
  template <class Part>
  static void measure(const std::vector<Part>& parts, const Points& before, const Points& after,
                      std::vector<double>& largest) {
    for (size_t k = 0; k < parts.size(); ++k)
      largest[k] =
          std::max(largest[k], fit_similarity(before, after, parts[k].vertices, 1.0).max_error);
  }
};

/// Whether each frame after a step comes from the one of its number. Of the others travel bends
/// nothing, and a morph everything.
bool keeps_frames(const SequenceStep& step) {
  return !std::holds_alternative<SequenceStep::Travel>(step.what) &&
         !std::holds_alternative<SequenceStep::Morph>(step.what);
}

/// What is measured on frames that come one after the other and are not kept.
class FrameMeasures {
 public:
  FrameMeasures(const TriangleMesh& mesh, const SequenceParts& parts,
                std::vector<SequenceReport::Foot> feet)
      : mesh_(mesh), parts_(parts), feet_(std::move(feet)) {
    centres_.resize(feet_.size());
  }

  void add(int frame, const Points& p) {
    last_.push_back(p);
    if (last_.size() > 3) last_.pop_front();
    if (last_.size() == 3 && p.rows() > 0)
      second_ = std::max(second_, (last_[2] - 2 * last_[1] + last_[0]).rowwise().norm().maxCoeff());
    turned_over_ += folds(p);
    for (size_t f = 0; f < feet_.size(); ++f)
      if (frame + 1 >= feet_[f].first && frame + 1 <= feet_[f].last)
        centres_[f].push_back(VertexCombination::mean_of(handle_vertices(feet_[f].handle)).at(p));
  }

  void fill(SequenceReport& report, const Bent& bent, double size) {
    report.second_difference = second_;
    report.turned_over = turned_over_;
    for (size_t h = 0; h < parts_.handles.size(); ++h)
      report.handles.push_back(
          {parts_.handles[h].name, count_of(parts_.handles[h].vertices), bent.handles[h]});
    for (size_t f = 0; f < parts_.features.size(); ++f)
      report.features.push_back(
          {parts_.features[f].name, count_of(parts_.features[f].vertices), bent.features[f]});
    for (size_t f = 0; f < feet_.size(); ++f) {
      Vec3 mean = Vec3::Zero();
      for (const Vec3& c : centres_[f]) mean += c / static_cast<double>(centres_[f].size());
      for (const Vec3& c : centres_[f])
        feet_[f].slip = std::max(feet_[f].slip, (c - mean).norm() / size);
    }
    report.feet = feet_;
  }

  double second() const { return second_; }
  long turned_over() const { return turned_over_; }

 private:
  const std::vector<int>& handle_vertices(const std::string& name) const {
    for (const auto& h : parts_.handles)
      if (h.name == name) return h.vertices;
    throw std::logic_error("a foot that is no handle");
  }

  // Triangles that look against the mean of their neighbours.
  long folds(const Points& p) const {
    const MeshTopology& topology = mesh_.topology();
    const auto normal = [&](int t) -> Vec3 {
      const auto& corners = topology.triangles()[t];
      const Vec3 a = p.row(topology.node_of(corners[0])), b = p.row(topology.node_of(corners[1])),
                 c = p.row(topology.node_of(corners[2]));
      return (b - a).cross(c - a);
    };
    long count = 0;
    for (int t = 0; t < topology.triangle_count(); ++t) {
      Vec3 around = Vec3::Zero();
      for (int corner = 0; corner < 3; ++corner)
        if (const int other = topology.across(t, corner); other >= 0) around += normal(other);
      count += normal(t).dot(around) < 0;
    }
    return count;
  }

  const TriangleMesh& mesh_;
  const SequenceParts& parts_;
  std::vector<SequenceReport::Foot> feet_;
  std::vector<std::vector<Vec3>> centres_;
  std::deque<Points> last_;
  double second_ = 0;
  long turned_over_ = 0;
};

/// One run of `batten sequence`.
class SequenceRun {
 public:
  SequenceRun(const SequenceScene& scene, const std::filesystem::path& folder,
              const SequenceTask& task, const Progress& progress)
      : scene_(scene), task_(task), progress_(progress), out_(folder), watch_(report_.timings) {}

  SequenceReport operator()() {
    read();
    find_parts();
    spare_input();
    do_steps();
    write_frames();
    draw();
    finish();
    return std::move(report_);
  }

 private:
  void read() {
    report_.name = scene_.name;
    report_.unit = scene_.unit;
    current_ = std::make_shared<PreparedSequence>(prepared_input());
    input_ = current_;
    const MeshSequence& s = current_->sequence;
    report_.file = scene_.source.path.filename().string();
    report_.frames_before = s.frame_count();
    report_.nodes = s.node_count();
    report_.faces = s.shells.face_count();
    report_.size = size_of(s);
    fingerprint_.add("batten sequence 1\n" +
                     input_bytes(scene_.file, "edits of a sequence (.toml)"));
    fingerprint_.add(s);
    add_files(scene_.selections);
    for (const auto& step : scene_.steps) {
      if (const auto* feet = std::get_if<SequenceStep::Footprints>(&step.what))
        fingerprint_.add_file(feet->terrain);
      if (const auto* mix = std::get_if<SequenceStep::Mix>(&step.what)) {
        fingerprint_.add(read_frames(scene_, mix->source, progress_));
        add_files(mix->selections);
      }
      if (const auto* morph = std::get_if<SequenceStep::Morph>(&step.what))
        fingerprint_.add(read_frames(scene_, morph->target, progress_));
    }
    watch_.lap("read");
  }

  void add_files(const std::vector<SelectRule>& selections) {
    for (const SelectRule& rule : selections)
      if (!rule.file.empty()) fingerprint_.add_file(rule.file);
  }

  PreparedSequence prepared_input() {
    MeshSequence sequence = read_frames(scene_, scene_.source, progress_);
    try {
      PreparedMesh prepared = prepare(sequence.shells);
      report_.warnings.insert(report_.warnings.end(), prepared.notes.begin(), prepared.notes.end());
      return {std::move(sequence), std::move(prepared.mesh)};
    } catch (const InputError& e) {
      throw InputError(scene_.at(scene_.source.place) + e.what());
    }
  }

  void find_parts() {
    file_.emplace(MeshFile::counted_from_1(input_->sequence.shells));
    select_.emplace(scene_, *file_, input_->mesh);
    for (const auto& h : scene_.handles) {
      parts_.handles.push_back({h.name, select_->of(h.vertices)});
      if (parts_.handles.back().vertices.empty())
        throw InputError(scene_.at(h.place) + "the handle '" + h.name + "' has no nodes");
    }
    for (const auto& h : scene_.handles)
      parts_.parents.push_back(h.parent.text.empty() ? -1 : parts_.handle(scene_, h.parent));
    for (const FeatureRule& rule : scene_.features) {
      if (!rule.name.empty()) {
        parts_.features.push_back({rule.name, select_->of(rule.vertices), rule.kind});
        continue;
      }
      for (const PlacedWord& word : rule.vertices)
        for (const PlacedWord& name : select_->matching(word))
          parts_.features.push_back({name.text, select_->of(name), rule.kind});
    }
    watch_.lap("parts");
  }

  /// A single file replaces what has its name.
  void spare_input() const {
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

  void do_steps() {
    const VerticesOf vertices_of = [&](const std::vector<PlacedWord>& names) {
      return select_->of(names);
    };
    last_ = as_it_is(current_);
    bent_.emplace(parts_);
    for (size_t k = 0; k < scene_.steps.size(); ++k) {
      if (k > 0) {
        const auto before = std::exchange(current_, collected(last_));
        for (size_t f = 0; keeps_frames(scene_.steps[k - 1]) && f < before->sequence.frames.size();
             ++f)
          bent_->measure(parts_, before->sequence.frames[f], current_->sequence.frames[f]);
      }
      const auto start = std::chrono::steady_clock::now();
      last_ = step(scene_.steps[k], vertices_of);
      last_.report.seconds = seconds_since(start);
      report_.steps.push_back(last_.report);
      for (const auto& w : last_.warnings) report_.warnings.push_back(last_.report.name + ": " + w);
      if (last_.report.not_at_rest > 0)
        report_.warnings.push_back(
            last_.report.name + ": " + std::to_string(last_.report.not_at_rest) + " of " +
            std::to_string(last_.report.keyframes) + " keyframes were not at rest after " +
            std::to_string(last_.report.rounds) + " rounds: nodes still moved by " +
            number(last_.report.last_change) + " of the size; rounds = … gives them more");
    }
    watch_.lap("steps");
  }

  /// Errors name the step and its place.
  StepResult step(const SequenceStep& rule, const VerticesOf& vertices_of) {
    const std::string where = scene_.at(rule.place) + "the step '" + rule.name + "': ";
    try {
      return do_step(scene_, rule, *current_, parts_, vertices_of, progress_);
    } catch (const ConflictError& e) {
      throw ConflictError(e.conflicts(), where);
    } catch (const InputError& e) {
      throw InputError(std::string(e.what()).starts_with(scene_.file.string()) ? e.what()
                                                                               : where + e.what());
    } catch (const NoSolutionError& e) {
      throw NoSolutionError(where + e.what());
    }
  }

  static StepResult as_it_is(const std::shared_ptr<PreparedSequence>& s) {
    StepResult result;
    result.shells = s->sequence.shells;
    result.times = s->sequence.times;
    result.frames = [s](int first, int last, const auto& take, const Progress&) {
      for (int k = first; k <= last; ++k) take(k, s->sequence.frames[k]);
    };
    return result;
  }

  std::shared_ptr<PreparedSequence> collected(const StepResult& result) const {
    MeshSequence sequence;
    sequence.shells = result.shells;
    sequence.times = result.times;
    result.frames(
        0, count_of(result.times) - 1, [&](int, const Points& p) { sequence.frames.push_back(p); },
        progress_);
    sequence.shells.points = sequence.frames.front();
    const MeshTopology& topology = input_->mesh.topology();
    Points vertices(topology.vertex_count(), 3);
    for (int v = 0; v < topology.vertex_count(); ++v)
      vertices.row(v) = sequence.frames.front().row(topology.node_of(v));
    return std::make_shared<PreparedSequence>(
        PreparedSequence{std::move(sequence), input_->mesh.with_points(std::move(vertices))});
  }

  /// glTF wants seconds.
  std::vector<double> written_times() const {
    std::vector<double> times = last_.times;
    const bool numbered =
        std::all_of(times.begin(), times.end(), [](double t) { return t == std::floor(t); });
    if (lower_extension(scene_.frames_out) == ".glb" && numbered)
      for (double& t : times) t = (t - last_.times.front()) / scene_.frames_per_second;
    return times;
  }

  void write_frames() {
    const int count = count_of(last_.times);
    const auto [first, last] = task_.frames.value_or(std::pair(1, count));
    if (first < 1 || last < first || last > count)
      throw InputError("--frames " + std::to_string(first) + ":" + std::to_string(last) +
                       ", and there are frames 1 to " + std::to_string(count));
    report_.frames = count;
    report_.first = first;
    report_.last = last;
    FrameStore store(out_.folder(), out_.file(scene_.frames_out), scene_.frames_out, last_.shells,
                     written_times(), first - 1, last - 1, fingerprint_.text());
    shown_ = shown_frames(scene_, report_.frames_before, first - 1, last - 1);
    FrameMeasures measures(input_->mesh, parts_, last_.feet);
    const auto look = [&](int k, const Points& p) {
      measures.add(k, p);
      if (!scene_.steps.empty() && keeps_frames(scene_.steps.back()))
        bent_->measure(parts_, current_->sequence.frames[k], p);
      if (std::binary_search(shown_.after.begin(), shown_.after.end(), k)) kept_.push_back(p);
    };
    for (int k = first - 1; k < last;) {
      if (store.have(k)) {
        look(k, store.read(k));
        ++report_.found;
        ++k;
        continue;
      }
      int end = k;
      while (end + 1 < last && !store.have(end + 1)) ++end;
      last_.frames(
          k, end,
          [&](int frame, const Points& p) {
            store.write(frame, p);
            look(frame, p);
          },
          progress_);
      k = end + 1;
    }
    report_.files = store.finish();
    measures.fill(report_, *bent_, report_.size);
    FrameMeasures before(input_->mesh, parts_, {});
    for (int k = 0; k < report_.frames_before; ++k) before.add(k, input_->sequence.frames[k]);
    report_.second_difference_before = before.second();
    report_.turned_over_before = before.turned_over();
    watch_.lap("frames");
  }

  void draw() {
    draw_sequence(report_, scene_, *input_, parts_, last_.shells, shown_, kept_, out_);
    watch_.lap("pictures");
  }

  std::vector<MissedPromise> broken() const {
    std::vector<MissedPromise> missed;
    for (const auto& f : report_.features)
      if (!(f.max_rigid_error <= 1e-10))
        missed.push_back({"features." + f.name, "is bent by " + number(f.max_rigid_error) +
                                                    " of its size, promised at most 1e-10"});
    for (const auto& f : report_.feet)
      if (!(f.slip <= f.promised))
        missed.push_back({"footprints." + f.handle,
                          "slips by " + number(f.slip) + " of the size in frames " +
                              std::to_string(f.first) + " to " + std::to_string(f.last) +
                              ", promised at most " + number(f.promised)});
    return missed;
  }

  void finish() {
    watch_.total();
    write_report(report_, broken(), out_, progress_);
    out_.commit();
  }

  const SequenceScene& scene_;
  const SequenceTask& task_;
  const Progress& progress_;
  OutputFolder out_;
  SequenceReport report_;
  Stopwatch watch_;
  Fingerprint fingerprint_;
  std::shared_ptr<PreparedSequence> input_, current_;
  std::optional<MeshFile> file_;
  std::optional<VertexSelector> select_;
  SequenceParts parts_;
  std::optional<Bent> bent_;
  StepResult last_;
  ShownFrames shown_;
  std::vector<Points> kept_;
};

}  // namespace

SequenceReport run_sequence(const SequenceScene& scene, const std::filesystem::path& folder,
                            const SequenceTask& task, const Progress& progress) {
  return SequenceRun(scene, folder, task, progress)();
}

std::string summary(const SequenceReport& report, const std::filesystem::path& folder) {
  std::string text = report.name + "\n";
  text += result_line("sequence", std::to_string(report.frames_before) + " frames, " +
                                      std::to_string(report.nodes) + " nodes, " +
                                      std::to_string(report.faces) + " faces");
  for (const auto& s : report.steps)
    text += result_line("step", s.name + " (" + s.kind + "): " + std::to_string(s.frames) +
                                    " frames, " + counted(s.keyframes, "keyframe") + ", " +
                                    number(s.seconds) + " s");
  text += result_line(
      "frames",
      std::to_string(report.first) + " to " + std::to_string(report.last) + " of " +
          std::to_string(report.frames) +
          (report.found > 0 ? ", " + std::to_string(report.found) + " of them were there" : ""));
  if (!report.feet.empty()) {
    double before = 0, after = 0;
    for (const auto& f : report.feet) {
      before = std::max(before, f.slip_before);
      after = std::max(after, f.slip);
    }
    text += result_line("footprints", std::to_string(report.feet.size()) + ", slip " +
                                          number(before) + " -> " + number(after) + " of the size");
  }
  double rigid = 0;
  for (const auto& f : report.features) rigid = std::max(rigid, f.max_rigid_error);
  if (!report.features.empty())
    text += result_line("features", std::to_string(report.features.size()) + ", rigid to " +
                                        number(rigid) + " of their size");
  text += result_line("smoothness",
                      "largest second difference " + number(report.second_difference_before) +
                          " -> " + number(report.second_difference) + " " + report.unit +
                          ", triangles turned over " + std::to_string(report.turned_over_before) +
                          " -> " + std::to_string(report.turned_over));
  return text + result_ending(report, folder);
}

}  // namespace batten
