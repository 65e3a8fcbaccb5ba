// SPDX-License-Identifier: MPL-2.0
#include "batten/scenes/sequence.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numeric>
#include <set>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/io/scene/scene_text.h"
#include "batten/io/sequences/sequence_writer.h"
#include "batten/scenes/mesh_data.h"
#include "batten/scenes/sequence_data.h"
#include "batten/scenes/sequences/frame_store.h"
#include "batten/scenes/sequences/sequence_edits.h"

namespace batten {

// Frames.

namespace {

/// Frames 1, 2, … if no times are given.
std::vector<double> times_or_numbers(std::vector<double> times, size_t count) {
  if (!times.empty()) return times;
  times.resize(count);
  std::iota(times.begin(), times.end(), 1.0);
  return times;
}

ShellMesh first_frame_faces(const std::vector<Points>& frames,
                            const std::vector<std::vector<int>>& faces) {
  if (frames.empty()) throw InputError("frames: found none, expected one or more");
  ShellMesh shells;
  shells.points = frames.front();
  for (const std::vector<int>& face : faces) shells.add_face(face);
  return shells;
}

std::shared_ptr<const detail::SequenceData> sequence_of_arrays(std::vector<Points> frames,
                                                               ShellMesh shells,
                                                               std::vector<double> times) {
  MeshSequence sequence{std::move(shells), std::move(frames), {}};
  sequence.times = times_or_numbers(std::move(times), sequence.frames.size());
  check(sequence, "frames");
  sequence.shells.points = sequence.frames.front();
  return std::make_shared<const detail::SequenceData>(detail::SequenceData{std::move(sequence)});
}

}  // namespace

Sequence::Sequence(std::vector<Points> frames, const std::vector<std::vector<int>>& faces,
                   std::vector<double> times) {
  ShellMesh shells = first_frame_faces(frames, faces);
  detail::SharedMesh valid{ShellMesh(shells)};  // throws for invalid faces
  data_ = sequence_of_arrays(std::move(frames), std::move(shells), std::move(times));
}

Sequence::Sequence(std::vector<Points> frames, const Mesh& mesh, std::vector<double> times)
    : data_(sequence_of_arrays(std::move(frames), mesh.data().shells(), std::move(times))) {}

int Sequence::frame_count() const { return data_->frames.frame_count(); }

const Points& Sequence::frame(int index) const {
  if (index < 0 || index >= frame_count())
    throw InputError("frame: found " + std::to_string(index) + ", expected 0 to " +
                     std::to_string(frame_count() - 1));
  return data_->frames.frames[static_cast<size_t>(index)];
}

const std::vector<double>& Sequence::times() const { return data_->frames.times; }

std::vector<std::vector<int>> Sequence::faces() const {
  const ShellMesh& shells = data_->frames.shells;
  std::vector<std::vector<int>> faces;
  for (int f = 0; f < shells.face_count(); ++f)
    faces.emplace_back(shells.corners(f).begin(), shells.corners(f).end());
  return faces;
}

Mesh Sequence::mesh(int index) const {
  ShellMesh shells = data_->frames.shells;
  shells.points = frame(index);
  return Mesh(std::make_shared<const detail::SharedMesh>(std::move(shells)));
}

std::vector<std::filesystem::path> Sequence::save(const std::filesystem::path& file,
                                                  double frames_per_second,
                                                  const Progress& progress) const {
  if (!(frames_per_second > 0) || !std::isfinite(frames_per_second))
    throw InputError("frames_per_second: found " + format_number(frames_per_second) +
                     ", expected a number above 0");
  SequenceWriter writer(file, data_->frames.shells,
                        written_times(file, times(), frames_per_second));
  for (int k = 0; k < frame_count(); ++k) {
    progress.update("writing frames", static_cast<double>(k) / frame_count());
    writer.write(k, frame(k));
  }
  writer.finish();
  return writer.files();
}

const std::string& Sequence::report() const { return data_->report; }
const std::vector<std::string>& Sequence::warnings() const { return data_->warnings; }
const std::vector<std::string>& Sequence::failed_checks() const { return data_->failed_checks; }

Sequence read_sequence(const std::filesystem::path& file, const SequenceOptions& options,
                       const Progress& progress) {
  return Sequence(std::make_shared<const detail::SequenceData>(
      detail::SequenceData{read_frames(file, options, progress)}));
}

// Edits.

namespace detail {
namespace {

/// Text of edits, and the lines of its parts.
class EditSource {
 public:
  explicit EditSource(const SequenceEditText& text) : text_(text) {
    if (text.operations.empty()) {
      whole_ = text.scene;
      return;
    }
    whole_ = "operation = [\n";
    for (const std::string& operation : text.operations) whole_ += "  " + operation + ",\n";
    whole_ += "]\n" + text.scene;
  }

  const std::string& whole() const { return whole_; }

  /// A message in which "CALLER: " and the number of the operation, or "CALLER:LINE:COLUMN: " of the
  /// scene, replace the location in whole(). `file`: name of whole() in messages.
  std::string with_part(const std::string& message, const std::string& file) const {
    if (!message.starts_with(file + ":")) return message;
    const size_t at = file.size() + 1;
    const size_t column = message.find(':', at), end = message.find(": ", at);
    const int line = std::atoi(message.c_str() + at);
    if (line < 1) return text_.caller + message.substr(file.size());
    const int added = text_.operations.empty() ? 0 : isize(text_.operations) + 2;
    if (line > added)
      return text_.caller + ":" + std::to_string(line - added) + message.substr(column);
    const std::string part = text_.single ? "" : "operations[" + std::to_string(line - 2) + "]: ";
    return text_.caller + ": " + part + message.substr(end + 2);
  }

 private:
  const SequenceEditText& text_;
  std::string whole_;
};

/// Adds the groups of the settings to a scene.
class GroupAdder {
 public:
  GroupAdder(SequenceScene& scene, int vertex_count) : scene_(scene), vertex_count_(vertex_count) {
    for (const SelectionSpec& rule : scene.selections) names_.insert(rule.name);
    for (const CutSpec& rule : scene.cuts) names_.insert(rule.name);
  }

  void add_selection(const VertexGroup& group, const std::string& what) {
    const std::string label = what + " '" + group.name + "': ";
    if (group.name.empty() || group.name.find('*') != std::string::npos)
      throw InputError(label + "expected a name without '*'");
    if (!names_.insert(group.name).second)
      throw InputError(label + "found the name twice, expected different names");
    if (group.vertices.empty()) throw InputError(label + "found no vertices, expected one or more");
    SelectionSpec rule;
    rule.name = group.name;
    for (const int v : group.vertices) {
      if (v < 0 || v >= vertex_count_)
        throw InputError(label + "found " + std::to_string(v) + ", expected 0 to " +
                         std::to_string(vertex_count_ - 1));
      rule.nodes.push_back(v + 1);  // the numbers of MeshFile::from_shells()
    }
    scene_.selections.push_back(std::move(rule));
  }

  void add_handle(const VertexGroup& group) {
    require_new_part(group, "handle");
    add_selection(group, "handle");
    scene_.handles.push_back({group.name, {}, {{group.name, {}}}, {}});
  }

  void add_feature(const VertexGroup& group, FormFeature::Kind kind) {
    require_new_part(group, "feature");
    add_selection(group, "feature");
    scene_.features.push_back({group.name, {}, {{group.name, {}}}, kind});
  }

  void add_fixed(const std::vector<int>& vertices) {
    if (vertices.empty()) return;
    add_selection({kFixed, vertices}, "fixed");
    for (SequenceOperation& step : scene_.steps) step.fixed.push_back({kFixed, {}});
  }

  void set_parents(const std::map<std::string, std::string>& parents) {
    std::vector<std::string> names;
    for (const SequenceHandle& handle : scene_.handles) names.push_back(handle.name);
    for (const auto& [child, parent] : parents)
      for (const std::string& name : {child, parent})
        if (std::find(names.begin(), names.end(), name) == names.end())
          throw InputError("parents: found the handle '" + name + "', expected one of the handles" +
                           did_you_mean(name, names));
    for (SequenceHandle& handle : scene_.handles)
      if (parents.count(handle.name)) handle.parent.text = parents.at(handle.name);
  }

 private:
  static constexpr const char* kFixed = "fixed vertices";

  void require_new_part(const VertexGroup& group, const std::string& what) const {
    const auto same = [&](const auto& part) { return part.name == group.name; };
    if (std::any_of(scene_.handles.begin(), scene_.handles.end(), same) ||
        std::any_of(scene_.features.begin(), scene_.features.end(), same))
      throw InputError(what + " '" + group.name +
                       "': found the name twice, expected different names");
  }

  SequenceScene& scene_;
  int vertex_count_;
  std::set<std::string> names_;
};

/// Replaces files of these names by sequences and meshes in memory.
class MemoryInputs {
 public:
  MemoryInputs(SequenceScene& scene, const SequenceSettings& settings)
      : scene_(scene), settings_(settings) {}

  void set_all() {
    for (SequenceOperation& step : scene_.steps) {
      if (auto* mix = std::get_if<SequenceOperation::Mix>(&step.what)) set_frames(mix->source);
      if (auto* morph = std::get_if<SequenceOperation::Morph>(&step.what))
        set_frames(morph->target);
      if (auto* feet = std::get_if<SequenceOperation::FootContacts>(&step.what))
        if (!feet->terrain.empty()) set_terrain(*feet);
    }
  }

 private:
  void set_frames(SequenceSource& source) {
    const Sequence* found = input_of(settings_.sequences, source.path, source.location, "sequence");
    if (!found) return;
    const MeshSequence& frames = found->data().frames;
    const FrameRange range = [&] {
      try {
        return frame_range(source.options, frames.frame_count(), source.path.filename().string());
      } catch (const InputError& e) {
        throw InputError(scene_.at(source.location) + e.what());
      }
    }();
    if (range.count == frames.frame_count()) {
      source.in_memory = {found->shared_data(), &frames};
      return;
    }
    auto part = std::make_shared<MeshSequence>();
    part->shells = frames.shells;
    for (int k = range.first; k < range.first + range.count; ++k) {
      part->frames.push_back(frames.frames[static_cast<size_t>(k)]);
      part->times.push_back(frames.times[static_cast<size_t>(k)]);
    }
    part->shells.points = part->frames.front();
    source.in_memory = std::move(part);
  }

  void set_terrain(SequenceOperation::FootContacts& feet) {
    if (const Mesh* found = input_of(settings_.meshes, feet.terrain, feet.terrain_location, "mesh"))
      feet.terrain_in_memory = {found->shared_data(), &found->data().shells()};
  }

  /// The input with the name of a file; nullptr: there is such a file. Throws InputError if there
  /// is neither.
  template <class Input>
  const Input* input_of(const std::map<std::string, Input>& inputs,
                        const std::filesystem::path& file, const SourceLocation& location,
                        const std::string& what) const {
    std::vector<std::string> names;
    for (const auto& [name, input] : inputs) {
      if (file == scene_.file.parent_path() / name) return &input;
      names.push_back(name);
    }
    std::error_code ignored;
    const std::string name = file.filename().string();
    if (names.empty() || name.find_first_of("*%") != name.npos ||
        std::filesystem::exists(file, ignored))
      return nullptr;
    throw InputError(scene_.at(location) + "found the " + what + " '" + name +
                     "', expected a file, or " + expected_one_of(name, names));
  }

  SequenceScene& scene_;
  const SequenceSettings& settings_;
};

int axis_of(const std::string& name) {
  const std::vector<std::string> names = {"x", "y", "z"};
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end())
    throw InputError("up: found '" + name + "', expected " + expected_one_of(name, names));
  return static_cast<int>(found - names.begin());
}

SequenceScene scene_of(const Sequence& sequence, const std::string& text,
                       const std::filesystem::path& file, const SequenceSettings& settings) {
  SequenceScene scene = parse_sequence_edits(text, file);
  GroupAdder groups(scene, sequence.data().frames.node_count());
  for (const VertexGroup& group : settings.handles) groups.add_handle(group);
  for (const VertexGroup& group : settings.features)
    groups.add_feature(group, FormFeature::Kind::Free);
  for (const VertexGroup& group : settings.keep_orientation)
    groups.add_feature(group, FormFeature::Kind::TranslationOnly);
  for (const VertexGroup& group : settings.selections) groups.add_selection(group, "selection");
  groups.add_fixed(settings.fixed);
  groups.set_parents(settings.parents);
  MemoryInputs(scene, settings).set_all();
  if (!settings.up.empty()) scene.up = axis_of(settings.up);
  return scene;
}

Sequence run_edits(const Sequence& sequence, const SequenceScene& scene, const Progress& progress) {
  SequenceReport report;
  SequenceEdits edits(scene, sequence.data().frames, report);
  edits.find_parts();
  const FrameReader read = [&](const SequenceSource& source) {
    if (source.in_memory) return *source.in_memory;
    try {
      return read_frames(source.path, source.options, progress);
    } catch (const InputError& e) {
      throw InputError(scene.at(source.location) + e.what());
    }
  };
  edits.apply(read, progress);
  auto data = std::make_shared<SequenceData>();
  data->frames.shells = edits.result().shells;
  data->frames.times = edits.result().times;
  report.frames = report.last = edits.frame_count();
  const auto keep = [&](int k, const Points& p) {
    edits.measure(k, p);
    data->frames.frames.push_back(p);
  };
  edits.make_frames(0, edits.frame_count() - 1, keep, progress);
  data->frames.shells.points = data->frames.frames.front();
  edits.finish_measures();
  report.failed_checks = edits.failed_checks();
  data->report = to_json(report);
  data->warnings = report.warnings;
  data->failed_checks = sentences(report.failed_checks);
  return Sequence(std::move(data));
}

}  // namespace

Sequence edited(const Sequence& sequence, const SequenceEditText& text,
                const SequenceSettings& settings, const Progress& progress) {
  const EditSource source(text);
  const std::filesystem::path file = text.folder / text.caller;
  try {
    return run_edits(sequence, scene_of(sequence, source.whole(), file, settings), progress);
  } catch (const InputError& e) {
    throw InputError(source.with_part(e.what(), file.string()));
  } catch (const NoSolutionError& e) {
    throw NoSolutionError(source.with_part(e.what(), file.string()));
  }
}

}  // namespace detail

Sequence Sequence::edited(const std::string& scene, const Progress& progress) const {
  return edited(scene, SequenceSettings{}, progress);
}

Sequence Sequence::edited(const std::string& scene, const SequenceSettings& settings,
                          const Progress& progress) const {
  detail::SequenceEditText text;
  text.scene = scene;
  return detail::edited(*this, text, settings, progress);
}

// Single operations.

namespace {

/// An operation as an inline table.
class OperationTable {
 public:
  explicit OperationTable(const std::string& type) : type_(type) {
    add("type", SceneText::toml_value(type));
    add("name", SceneText::toml_value(type));
  }
  void add(const std::string& key, const std::string& value) { values_.emplace_back(key, value); }
  /// Adds a range of frames, which are numbered from 0.
  void add_frames(const std::string& key, const std::optional<std::pair<int, int>>& range) {
    if (range)
      add(key,
          "[" + std::to_string(range->first + 1) + ", " + std::to_string(range->second + 1) + "]");
  }

  Sequence apply(const Sequence& sequence, const std::string& keys,
                 const SequenceSettings& settings, const Progress& progress) const {
    std::string table = SceneText::inline_table(values_);
    const bool more = keys.find_first_not_of(" \t") != std::string::npos;
    if (more) table.insert(table.rfind('}'), ", " + keys + " ");
    if (keys.find('\n') != std::string::npos)
      throw InputError(type_ +
                       "(): keys: found several lines, expected keys as in an inline table");
    detail::SequenceEditText text;
    text.caller = type_ + "()";
    text.operations = {table};
    text.single = true;
    return detail::edited(sequence, text, settings, progress);
  }

 private:
  std::string type_;
  std::vector<SceneText::Value> values_;
};

std::string finite_value(double value, const std::string& what) {
  if (std::isfinite(value)) return SceneText::toml_value(value);
  throw InputError(what + ": found " + format_number(value) + ", expected a finite number");
}

std::string finite_value(const Vec3& v, const std::string& what) {
  return SceneText::list(
      {finite_value(v[0], what), finite_value(v[1], what), finite_value(v[2], what)});
}

std::string move_table(const std::string& handle, const Move& move, const std::string& label) {
  if (move.scale != 1)
    throw InputError(label + "scale: found " + format_number(move.scale) +
                     ", expected 1: handles of a sequence move rigidly");
  std::vector<SceneText::Value> values = {
      {"name", SceneText::toml_value(handle)},
      {"translate", finite_value(move.translate, label + "translate")}};
  if (move.angle != 0)
    values.emplace_back(
        "rotate", SceneText::inline_table({{"axis", finite_value(move.axis, label + "axis")},
                                           {"angle", finite_value(move.angle, label + "angle")}}));
  if (move.about) values.emplace_back("about", finite_value(*move.about, label + "about"));
  return SceneText::inline_table(values);
}

std::string names_of(const std::vector<VertexGroup>& groups) {
  std::vector<std::string> names;
  for (const VertexGroup& group : groups) names.push_back(group.name);
  return SceneText::toml_string_list(names);
}

}  // namespace

Sequence Sequence::keyframes(const std::map<int, std::map<std::string, Move>>& moves,
                             const SequenceSettings& settings,
                             const std::optional<std::pair<int, int>>& influence,
                             const std::string& keys, const Progress& progress) const {
  if (moves.empty()) throw InputError("keyframes(): found no keyframes, expected one or more");
  std::vector<std::string> keyframes;
  for (const auto& [frame, of_handles] : moves) {
    const std::string label = "keyframes(): moves[" + std::to_string(frame) + "]";
    if (frame < 0 || frame >= frame_count())
      throw InputError(label + ": found frame " + std::to_string(frame) + ", expected 0 to " +
                       std::to_string(frame_count() - 1));
    std::vector<std::string> tables;
    for (const auto& [handle, move] : of_handles)
      tables.push_back(move_table(handle, move, label + "['" + handle + "']: "));
    keyframes.push_back(SceneText::inline_table(
        {{"frame", std::to_string(frame + 1)}, {"handle", SceneText::list(tables)}}));
  }
  OperationTable operation("keyframes");
  operation.add("keyframe", SceneText::list(keyframes));
  operation.add_frames("influence", influence);
  return operation.apply(*this, keys, settings, progress);
}

Sequence Sequence::filter(const std::string& kind, const SequenceSettings& settings, double sigma,
                          const std::string& keys, const Progress& progress) const {
  if (settings.handles.empty())
    throw InputError("filter(): handles: found none, expected handles whose motion is filtered");
  OperationTable operation("filter");
  operation.add("filter", SceneText::toml_value(kind));
  operation.add("handles", names_of(settings.handles));
  operation.add("sigma", finite_value(sigma, "filter(): sigma"));
  return operation.apply(*this, keys, settings, progress);
}

Sequence Sequence::mix(const Sequence& source, const std::map<std::string, std::vector<int>>& from,
                       const SequenceSettings& settings, const std::string& keys,
                       const Progress& progress) const {
  const std::string name = "source";
  const int vertex_count = source.data().frames.node_count();
  std::vector<std::string> selections, pairs;
  for (const auto& [handle, vertices] : from) {
    const std::string text = SceneText::toml_value(handle);
    if (vertices.empty()) {
      pairs.push_back("{ handle = " + text + " }");
      continue;
    }
    std::vector<std::string> numbers;
    for (const int v : vertices) {
      if (v < 0 || v >= vertex_count)
        throw InputError("mix(): from['" + handle + "']: found " + std::to_string(v) +
                         ", expected 0 to " + std::to_string(vertex_count - 1));
      numbers.push_back(std::to_string(v + 1));
    }
    selections.push_back("{ name = " + text + ", nodes = " + SceneText::list(numbers) + " }");
    pairs.push_back("{ handle = " + text + ", from = " + text + " }");
  }
  if (pairs.empty()) throw InputError("mix(): from: found no handles, expected one or more");
  OperationTable operation("mix");
  std::vector<SceneText::Value> of_source = {{"file", SceneText::toml_value(name)}};
  if (!selections.empty()) of_source.emplace_back("select", SceneText::list(selections));
  operation.add("source", SceneText::inline_table(of_source));
  operation.add("pair", SceneText::list(pairs));
  SequenceSettings all = settings;
  all.sequences.insert_or_assign(name, source);
  return operation.apply(*this, keys, all, progress);
}

Sequence Sequence::morph(const Sequence& target, const Progress& progress) const {
  return morph(target, MorphSettings{}, progress);
}

Sequence Sequence::morph(const Sequence& target, const MorphSettings& settings,
                         const Progress& progress) const {
  const std::string name = "target";
  OperationTable operation("morph");
  std::string of_target = "{ file = " + SceneText::toml_value(name);
  if (const auto& range = settings.target_interval)
    of_target += ", interval = [" + std::to_string(range->first + 1) + ", " +
                 std::to_string(range->second + 1) + "]";
  operation.add("target", of_target + " }");
  operation.add_frames("interval", settings.interval);
  if (settings.frames != 0) operation.add("frames", std::to_string(settings.frames));
  std::vector<std::string> landmarks;
  for (const auto& [from, to] : settings.landmarks) {
    const std::string label = "morph(): landmarks[" + std::to_string(landmarks.size()) + "]";
    landmarks.push_back("{ from = " + finite_value(from, label) +
                        ", to = " + finite_value(to, label) + " }");
  }
  if (!landmarks.empty()) operation.add("landmark", SceneText::list(landmarks));
  SequenceSettings memory;
  memory.up = settings.up;
  memory.sequences.emplace(name, target);
  return operation.apply(*this, settings.keys, memory, progress);
}

}  // namespace batten
