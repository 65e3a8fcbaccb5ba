#include "batten/apps/commands/documents/edited_sequence.h"

#include <algorithm>

#include "batten/apps/commands/runs/run_parts.h"
#include "batten/apps/commands/sequences/run_sequence.h"
#include "batten/core/index.h"
#include "batten/io/files/length_units.h"
#include "batten/io/files/text.h"
#include "batten/io/scene/scene_words.h"

namespace batten {
namespace {

using Role = MeshView::Role;
using Part = MeshView::Part;

}  // namespace

/// What decides the frames that are read, the parts of the mesh, and each step.
struct EditedSequence::Words {
  Words() = default;
  explicit Words(const std::string& text) {
    toml::table root = parse_toml(text, {}, "edits of a sequence");
    if (const toml::node* frames = root.get("sequence")) source = toml_words(*frames);
    if (const toml::array* list = root["step"].as_array())
      for (const toml::node& step : *list) steps.push_back(toml_words(step));
    for (const char* kind : {"sequence", "step", "output", "picture", "name"}) root.erase(kind);
    parts = toml_words(root);
  }
  std::string source, parts;
  std::vector<std::string> steps;
};

struct EditedSequence::Made {
  Made(const SequenceScene& s, std::shared_ptr<const PreparedSequence> read)
      : scene(s),
        input(std::move(read)),
        file(MeshFile::counted_from_1(input->sequence.shells)),
        select(scene, file, input->mesh),
        parts(find_sequence_parts(scene, select)) {}

  const PreparedSequence& last() const { return after.empty() ? *input : *after.back().frames; }
  void do_steps(const Progress& progress);
  void show();
  Points vertices(const Points& nodes) const;
  Vec3 centre(const Handle& handle, const Points& nodes) const {
    return VertexCombination::mean_of(handle.vertices).at(nodes);
  }

  SequenceScene scene;
  Words words;
  std::shared_ptr<const PreparedSequence> input;
  MeshFile file;
  VertexSelector select;
  SequenceParts parts;
  /// What a step gave, and the feet that it planted.
  struct Done {
    std::shared_ptr<const PreparedSequence> frames;
    std::vector<SequenceReport::Foot> feet;
  };
  std::vector<Done> after;  // each step
  std::unique_ptr<const MeshDisplay> display;
  std::shared_ptr<const MeshView> view;
};

EditedSequence::EditedSequence() = default;
EditedSequence::~EditedSequence() = default;

void EditedSequence::become(const SceneText& text, const std::filesystem::path& file,
                            const Progress& progress) {
  const SequenceScene scene = parse_sequence_scene(text.text(), named_file(file));
  const Words words(text.text());
  std::vector<std::string> notes;
  progress.at("frames", 0);
  const bool same_source =
      made_ && words.source == made_->words.source && scene.source.path == made_->scene.source.path;
  auto made = std::make_unique<Made>(
      scene, same_source ? made_->input
                         : std::make_shared<const PreparedSequence>(prepared_sequence(
                               read_sequence(scene.source.path, scene.source.options, progress),
                               scene.at(scene.source.place), notes)));
  made->words = words;
  for (size_t k = 0; same_source && words.parts == made_->words.parts && k < made_->after.size() &&
                     k < words.steps.size() && words.steps[k] == made_->words.steps[k];
       ++k)
    made->after.push_back(made_->after[k]);
  std::string problem;
  try {
    made->do_steps(progress);
  } catch (const CancelledError&) {
    throw;
  } catch (const Error& e) {
    if (made_ && problem_.empty()) throw;
    problem = e.what();
  }
  made->show();
  made_ = std::move(made);
  scene_ = scene;
  problem_ = problem;
  frame_ = std::clamp(frame_, 0, frames().frame_count() - 1);
}

void EditedSequence::Made::do_steps(const Progress& progress) {
  const ReadFrames read = [&](const SequenceSource& source) {
    return read_sequence(source.path, source.options, progress);
  };
  for (size_t k = after.size(); k < scene.steps.size(); ++k) {
    const SequenceStep& step = scene.steps[k];
    progress.at(step.name, static_cast<double>(k) / static_cast<double>(scene.steps.size()));
    const PreparedSequence& from = last();
    const StepResult result = done_step(scene, step, from, parts, select, read, progress);
    after.push_back(
        {naming_step(scene, step, [&] { return collected(result, input->mesh, progress); }),
         result.feet});
  }
}

Points EditedSequence::Made::vertices(const Points& nodes) const {
  const MeshTopology& topology = input->mesh.topology();
  Points all(topology.vertex_count(), 3);
  for (int v = 0; v < topology.vertex_count(); ++v) all.row(v) = nodes.row(topology.node_of(v));
  return all;
}

void EditedSequence::Made::show() {
  display =
      std::make_unique<const MeshDisplay>(input->mesh, input->mesh.topology().boundary_loops());
  auto seen = std::make_shared<MeshView>();
  const std::vector<int>& of = display->vertices();
  const MeshTopology& topology = input->mesh.topology();
  std::vector<std::vector<int>> points_of(topology.node_count());
  for (int p = 0; p < count_of(of); ++p) {
    const int node = topology.node_of(of[p]);
    points_of[node].push_back(p);
    seen->labels.push_back(node + 1);
  }
  seen->roles.assign(of.size(), Role::Free);
  for (const int v : of)
    for (const double x : input->mesh.point(v)) seen->rest.push_back(static_cast<float>(x));
  const auto part = [&](const std::string& name, const std::vector<int>& nodes, Role role) {
    Part one{Part::Kind::Selection, name, "", 0, {}};
    for (const int node : nodes)
      one.points.insert(one.points.end(), points_of[node].begin(), points_of[node].end());
    for (const int p : one.points)
      if (role != Role::Free) seen->roles[p] = role;
    if (std::none_of(seen->parts.begin(), seen->parts.end(),
                     [&](const Part& other) { return other.name == name; }))
      seen->parts.push_back(std::move(one));
  };
  for (const SelectRule& rule : scene.selections)
    part(rule.name, select.of({rule.name, rule.place}), Role::Free);
  for (const FormFeature& f : parts.features) part(f.name, f.vertices, Role::Feature);
  for (const Handle& h : parts.handles) part(h.name, h.vertices, Role::Handle);
  view = std::move(seen);
}

void EditedSequence::restate(const SceneText& text, const std::filesystem::path& file) {
  scene_ = parse_sequence_scene(text.text(), named_file(file));
}

void EditedSequence::check(const std::string& parameter, double) const {
  throw InputError("found '" + parameter + "', and a sequence has no parameters");
}

void EditedSequence::show_frame(int frame) {
  if (made_) frame_ = std::clamp(frame, 0, frames().frame_count() - 1);
}

bool EditedSequence::draw(Frame& frame) {
  if (!made_) return false;
  made_->display->draw(made_->vertices(frames().frames[frame_]), frame);
  return true;
}

const MeshSequence& EditedSequence::frames() const { return made_->last().sequence; }

void EditedSequence::look_at(DocumentView& view) const {
  view.unit = scene_.unit;
  if (!made_) return;
  view.surface = true;
  view.triangles = made_->input->mesh.triangle_count();
  view.size = made_->input->mesh.size();
  view.regions = {scene_.source.path.filename().string()};
  view.mesh = made_->view;
  DocumentView::Timeline& timeline = view.timeline.emplace();
  timeline.frames = frames().frame_count();
  timeline.frame = frame_;
  const SequenceStep::Keyframes* keys = nullptr;
  if (!scene_.steps.empty()) keys = std::get_if<SequenceStep::Keyframes>(&scene_.steps.back().what);
  for (size_t k = 0; keys && k < keys->keys.size(); ++k)
    timeline.keyframes.push_back(keys->keys[k].frame - 1);
  std::sort(timeline.keyframes.begin(), timeline.keyframes.end());
  static const std::vector<SequenceReport::Foot> kNoFeet;
  for (const auto& foot : made_->after.empty() ? kNoFeet : made_->after.back().feet)
    for (const Handle& h : made_->parts.handles)
      if (h.name == foot.handle)
        timeline.footprints.push_back(
            made_->centre(h, frames().frames[std::clamp(foot.first - 1, 0, timeline.frames - 1)]));
  for (const Handle& h : made_->parts.handles) {
    DocumentView::Handle handle{h.name, made_->centre(h, frames().frames[frame_])};
    for (const Points& nodes : frames().frames) handle.path.push_back(made_->centre(h, nodes));
    for (size_t k = 0; keys && k < keys->keys.size(); ++k)
      for (const auto& move : keys->keys[k].moves)
        if (keys->keys[k].frame == frame_ + 1 && move.handle.text == h.name) {
          handle.shift = move.translate;
          handle.turn = move.degrees * move.axis;
        }
    handle.moves = true;
    view.handles.push_back(std::move(handle));
  }
}

std::string EditedSequence::rows() const {
  if (!problem_.empty()) return result_line("sequence", problem_);
  return result_line("sequence", counted(frames().frame_count(), "frame") + ", " +
                                     counted(made_->input->sequence.node_count(), "node") + ", " +
                                     counted(static_cast<long>(scene_.steps.size()), "step"));
}

std::string EditedSequence::run(const std::filesystem::path& folder, const Progress& progress) {
  std::string text;
  for (const MissedPromise& one : run_sequence(scene_, folder, {}, progress).missed)
    text += one.what + ": " + one.detail + "\n";
  return text;
}

std::string EditedSequence::export_shape(const std::filesystem::path& file, const Progress&) {
  ShellMesh shells = frames().shells;
  shells.points = frames().frames[frame_];
  write_mesh(file, shells, {}, unit_in_metres(scene_.unit));
  return "";
}

}  // namespace batten
