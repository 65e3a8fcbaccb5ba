#include "batten/apps/commands/sequences/run_sequence.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "batten/apps/commands/runs/run_support.h"
#include "batten/apps/commands/sequences/frame_measures.h"
#include "batten/apps/commands/sequences/frame_store.h"
#include "batten/apps/commands/sequences/sequence_frames.h"
#include "batten/apps/commands/sequences/sequence_pictures.h"
#include "batten/core/errors.h"
#include "batten/io/files/input_file.h"
#include "batten/io/files/text.h"

namespace batten {
namespace {

/// Whether each frame after a step comes from the one of its number. Of the others travel bends
/// nothing, and a morph everything.
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
                     read_input_file(scene_.file, "edits of a sequence (.toml)"));
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

  /// The frames of a source. They count for the fingerprint; errors name their place in the scene.
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

  /// A single file replaces what has its name.
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
              last_.report.name + ": '" + foot.handle + "' counts as standing in frames " +
              std::to_string(foot.first) + " to " + std::to_string(foot.last) +
              ", in which it moves by " + format_number(foot.foot_skate_before) +
              " of the size: is found = { within = … } too large?");
      if (last_.report.unconverged_keyframes > 0)
        report_.warnings.push_back(
            last_.report.name + ": " + std::to_string(last_.report.unconverged_keyframes) + " of " +
            std::to_string(last_.report.keyframes) + " keyframes were not at rest after " +
            std::to_string(last_.report.iterations) + " rounds: nodes still moved by " +
            format_number(last_.report.last_change) + " of the size; rounds = … gives them more");
    }
    watch_.lap("steps");
  }

  StepResult step(const SequenceOperation& rule) {
    const FrameReader read = [&](const SequenceSource& source) { return read_frames(source); };
    return run_step(scene_, rule, *current_, parts_, *select_, read, progress_);
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

  /// Makes frames of the last step.
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
    measures.fill(report_, *deviation_, report_.size);
    FrameMeasures before(input_->mesh, parts_, {});
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
        failed_checks.push_back({"features." + f.name, "is bent by " +
                                                           format_number(f.max_rigid_error) +
                                                           " of its size, promised at most 1e-10"});
    for (const auto& f : report_.feet)
      if (!(f.foot_skate <= f.max_foot_skate))
        failed_checks.push_back(
            {"footprints." + f.handle, "slips by " + format_number(f.foot_skate) +
                                           " of the size in frames " + std::to_string(f.first) +
                                           " to " + std::to_string(f.last) + ", promised at most " +
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

}  // namespace batten
