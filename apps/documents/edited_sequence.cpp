// SPDX-License-Identifier: MPL-2.0
#include "batten/apps/documents/edited_sequence.h"

#include <algorithm>

#include "batten/core/containers.h"
#include "batten/io/files/text.h"
#include "batten/io/scene/scene_parsing.h"
#include "batten/scenes/commands.h"
#include "batten/scenes/runs/run_support.h"

namespace batten {
namespace {

using Role = MeshView::Role;
using Part = MeshView::Part;

}  // namespace

/// The parts of the text that determine the frames read, the mesh parts, and each step.
struct EditedSequence::Sections {
  Sections() = default;
  explicit Sections(const std::string& text) {
    toml::table root = parse_toml(text, {}, "a sequence scene");
    if (const toml::node* frames = root.get("sequence")) source = to_toml(*frames);
    if (const toml::array* list = root["operation"].as_array())
      for (const toml::node& step : *list) steps.push_back(to_toml(step));
    for (const char* kind : {"sequence", "operation", "output", "picture", "name"})
      root.erase(kind);
    parts = to_toml(root);
  }
  std::string source, parts;
  std::vector<std::string> steps;
};

struct EditedSequence::State {
  State(const SequenceScene& s, std::shared_ptr<const PreparedSequence> read)
      : scene(s),
        input(std::move(read)),
        file(MeshFile::from_shells(input->sequence.shells)),
        select(scene, file, input->mesh),
        parts(find_sequence_parts(scene, select)) {}

  const PreparedSequence& last() const { return after.empty() ? *input : *after.back().frames; }
  void apply_steps(const Progress& progress);
  void show();
  Points vertices(const Points& nodes) const;
  Vec3 centre(const Handle& handle, const Points& nodes) const {
    return VertexCombination::mean_of(handle.vertices).at(nodes);
  }

  SequenceScene scene;
  Sections sections;
  std::shared_ptr<const PreparedSequence> input;
  MeshFile file;
  VertexSelector select;
  SequenceParts parts;
  /// Result of a step, with the feet that it planted.
  struct Done {
    std::shared_ptr<const PreparedSequence> frames;
    std::vector<SequenceReport::Foot> feet;
  };
  std::vector<Done> after;  // per step
  std::unique_ptr<const MeshDisplay> display;
  std::shared_ptr<const MeshView> view;
};

EditedSequence::EditedSequence() = default;
EditedSequence::~EditedSequence() = default;

void EditedSequence::rebuild(const SceneText& text, const std::filesystem::path& file,
                             const Progress& progress) {
  const SequenceScene scene = parse_sequence_scene(text.text(), named_file(file));
  const Sections sections(text.text());
  std::vector<std::string> notes;
  progress.update("frames", 0);
  const bool same_source = made_ && sections.source == made_->sections.source &&
                           scene.source.path == made_->scene.source.path;
  auto made = std::make_unique<State>(
      scene, same_source ? made_->input
                         : std::make_shared<const PreparedSequence>(prepared_sequence(
                               read_frames(scene.source.path, scene.source.options, progress),
                               scene.at(scene.source.location), notes)));
  made->sections = sections;
  for (size_t k = 0;
       same_source && sections.parts == made_->sections.parts && k < made_->after.size() &&
       k < sections.steps.size() && sections.steps[k] == made_->sections.steps[k];
       ++k)
    made->after.push_back(made_->after[k]);
  std::string problem;
  try {
    made->apply_steps(progress);
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

void EditedSequence::State::apply_steps(const Progress& progress) {
  const FrameReader read = [&](const SequenceSource& source) {
    return read_frames(source.path, source.options, progress);
  };
  for (size_t k = after.size(); k < scene.steps.size(); ++k) {
    const SequenceOperation& step = scene.steps[k];
    progress.update(step.name, static_cast<double>(k) / static_cast<double>(scene.steps.size()));
    const PreparedSequence& from = last();
    const StepResult result = run_step(scene, step, from, parts, select, read, progress);
    after.push_back(
        {with_step_context(scene, step,
                           [&] { return collect_frames(result, input->mesh, progress); }),
         result.feet});
  }
}

Points EditedSequence::State::vertices(const Points& nodes) const {
  const MeshTopology& topology = input->mesh.topology();
  Points all(topology.vertex_count(), 3);
  for (int v = 0; v < topology.vertex_count(); ++v) all.row(v) = nodes.row(topology.node_of(v));
  return all;
}

void EditedSequence::State::show() {
  display =
      std::make_unique<const MeshDisplay>(input->mesh, input->mesh.topology().boundary_loops());
  auto seen = std::make_shared<MeshView>();
  const std::vector<int>& of = display->vertices();
  const MeshTopology& topology = input->mesh.topology();
  std::vector<std::vector<int>> points_of(topology.node_count());
  for (int p = 0; p < isize(of); ++p) {
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
  for (const SelectionSpec& rule : scene.selections)
    part(rule.name, select.of({rule.name, rule.location}), Role::Free);
  for (const FormFeature& f : parts.features) part(f.name, f.vertices, Role::Feature);
  for (const Handle& h : parts.handles) part(h.name, h.vertices, Role::Handle);
  view = std::move(seen);
}

void EditedSequence::update_text(const SceneText& text, const std::filesystem::path& file) {
  scene_ = parse_sequence_scene(text.text(), named_file(file));
}

void EditedSequence::check(const std::string& parameter, double) const {
  throw InputError("found the parameter '" + parameter +
                   "', expected none: a sequence scene has no parameters");
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

void EditedSequence::fill_view(DocumentView& view) const {
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
  const SequenceOperation::Keyframes* keys = nullptr;
  if (!scene_.steps.empty())
    keys = std::get_if<SequenceOperation::Keyframes>(&scene_.steps.back().what);
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
          handle.rotation_vector = move.degrees * move.axis;
        }
    handle.moves = true;
    view.handles.push_back(std::move(handle));
  }
}

std::string EditedSequence::rows() const {
  if (!problem_.empty()) return summary_line("sequence", problem_);
  return summary_line("sequence",
                      format_count(frames().frame_count(), "frame") + ", " +
                          format_count(made_->input->sequence.node_count(), "node") + ", " +
                          format_count(static_cast<long>(scene_.steps.size()), "operation"));
}

std::string EditedSequence::run(const std::filesystem::path& folder, const Progress& progress) {
  return sentence_lines(run_sequence(scene_, folder, {}, progress).failed_checks);
}

std::string EditedSequence::export_shape(const std::filesystem::path& file, const Progress&) {
  ShellMesh shells = frames().shells;
  shells.points = frames().frames[frame_];
  write_mesh(file, shells, {}, unit_in_metres(scene_.unit));
  return "";
}

}  // namespace batten
