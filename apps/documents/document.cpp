// SPDX-License-Identifier: MPL-2.0
#include "batten/apps/documents/document.h"

#include <algorithm>
#include <fstream>
#include <functional>
#include <sstream>

#include "batten/apps/documents/edited_mesh.h"
#include "batten/apps/documents/edited_sequence.h"
#include "batten/apps/documents/edited_shape.h"
#include "batten/apps/documents/line_edits.h"
#include "batten/io/files/atomic_file.h"
#include "batten/io/files/command_files.h"
#include "batten/io/files/input_file.h"
#include "batten/io/lines/cad_plugin.h"
#include "batten/io/scene/scene_parsing.h"
#include "batten/io/scene/scene_paths.h"
#include "batten/scenes/commands.h"
#include "batten/scenes/lines/line_files.h"
#include "batten/scenes/runs/run_support.h"

namespace batten {

std::filesystem::path named_file(const std::filesystem::path& file) {
  return file.empty() ? std::filesystem::path("untitled") : file;
}

namespace {

using CommandKind = DocumentCommand::CommandKind;

std::string new_scene(const std::string& unit) {
  return "unit = " + SceneText::toml_value(unit) + "\n\n[skin]\n";
}

/// A file as an absolute path in TOML, valid in a scene anywhere.
std::string path_to_toml(const std::filesystem::path& file) {
  return SceneText::toml_value(std::filesystem::absolute(file).string());
}

/// Kind of a scene: sequence, mesh, or curves.
enum class ContentKind { Lines, Mesh, Sequence };
ContentKind content_kind(const SceneText& text, const std::filesystem::path& file) {
  const toml::table root = parse_toml(text.text(), named_file(file), "a scene");
  if (root.contains("sequence")) return ContentKind::Sequence;
  // [mesh], a table, belongs to surface scenes.
  const bool mesh_file = root["mesh"].is_string();
  return mesh_file || root.contains("edit") ? ContentKind::Mesh : ContentKind::Lines;
}

/// A new scene for a curve file, a mesh or a sequence.
SceneText scene_around(const std::filesystem::path& file) {
  if (file_kind(file) == FileKind::Mesh) {
    SceneText text("unit = \"mm\"\nmesh = " + path_to_toml(file) + "\n");
    text.add("edit", "{ name = \"edit 1\" }");
    return text;
  }
  if (file_kind(file) == FileKind::Sequence)
    return SceneText("unit = \"m\"\n\n[sequence]\nfile = " + path_to_toml(file) + "\n");
  require_input_file(file, "a curve file");
  SceneText text(new_scene("mm"));
  text.add("curves", "{ file = " + path_to_toml(file) + " }");
  return text;
}

}  // namespace

Document::Document() : text_(new_scene("mm")), saved_(text_.text()) {
  content_ = next_content(text_, {}, {});
}
Document::~Document() = default;
Document::Document(Document&&) noexcept = default;
Document& Document::operator=(Document&&) noexcept = default;

void Document::apply(const DocumentCommand& command, const Progress& progress) {
  run_messages_.clear();
  const bool keeps_state =
      command.kind == CommandKind::SetSlider || command.kind == CommandKind::SolvePreview ||
      command.kind == CommandKind::Step || command.kind == CommandKind::SolveToEquilibrium;
  if (content_->in_motion() && !keeps_state) solve_to_equilibrium();
  if (!keeps_state) new_load_.clear();
  if (command.kind != CommandKind::SetSlider && command.kind != CommandKind::SolvePreview &&
      command.kind != CommandKind::Move)
    dragged_.clear();
  switch (command.kind) {
    case CommandKind::Open:
      return open(command.file, progress);
    case CommandKind::Recover:
      return recover(command.file, progress);
    case CommandKind::New:
      return start(SceneText(new_scene(command.key)), {}, progress);
    case CommandKind::Add:
    case CommandKind::Set:
    case CommandKind::Erase:
    case CommandKind::Remove:
      return edit(command, progress);
    case CommandKind::Move:
      return move(command.text, progress);
    case CommandKind::SetSlider:
      return set_slider(command.key, command.value, progress);
    case CommandKind::SolvePreview:
      at_rest_ = content_->in_motion() || content_->solve_preview();
      return;
    case CommandKind::Step:
      return content_->step(command.value);
    case CommandKind::SolveToEquilibrium:
      return solve_to_equilibrium();
    case CommandKind::Undo:
      return restore(undo_, redo_, progress);
    case CommandKind::Redo:
      return restore(redo_, undo_, progress);
    case CommandKind::Save:
      return save(command.file);
    case CommandKind::Export:
      require_inputs_preserved(command.file);
      if (!changed_sliders_.empty()) solve_to_equilibrium();
      run_messages_ = content_->export_shape(command.file, progress);
      return;
    case CommandKind::Run:
      if (!changed_sliders_.empty()) solve_to_equilibrium();
      run_messages_ = content_->run(command.file, progress);
      return;
  }
}

void Document::open(const std::filesystem::path& file, const Progress& progress) {
  const FileKind kind = file_kind(file);
  const bool wrapped = kind == FileKind::Mesh || kind == FileKind::Sequence ||
                       line_file_kind(file) != LineFileKind::None;
  if (!wrapped)
    return start(SceneText(read_input_file(file, "a scene, a mesh or a curve file"), file), file,
                 progress);
  start(scene_around(file), {}, progress);
  if (kind != FileKind::Cad) return;
  if (const int faces = cad_plugin().read_cad_contents(file).faces; faces > 0)
    run_messages_ = cad_faces_note(file, faces) + "\n";
}

// Opens in a new document first, so that this one stays unchanged if the file is no scene.
void Document::start(SceneText text, const std::filesystem::path& file, const Progress& progress) {
  Document other;
  other.file_ = file;
  other.saved_ = text.text();
  other.rebuild(std::move(text), progress);
  const EditedShape* shape = other.shape();
  const bool unread = shape && shape->lines().empty() && !other.content().problem().empty();
  if (unread) throw InputError(other.content().problem());
  *this = std::move(other);
}

void Document::edit(const DocumentCommand& command, const Progress& progress) {
  if (!changed_sliders_.empty()) solve_to_equilibrium();
  SceneText next = text_;
  SceneTable added;
  if (command.kind == CommandKind::Add) added = next.add(command.table.kind, command.text);
  if (command.kind == CommandKind::Set)
    next = with_single_shape_key(std::move(next), command.table, command.key, command.text);
  if (command.kind == CommandKind::Erase) next.erase(command.table, command.key);
  if (command.kind == CommandKind::Remove) next.remove(command.table);
  const bool fresh = added.kind == "load" && next.value(added, "value") == "0";
  change(std::move(next), progress);
  if (fresh) new_load_ = added.name;
}

// Consecutive moves of a point form one undo step: each starts from the text before the first one.
void Document::move(const std::string& from_to, const Progress& progress) {
  if (!changed_sliders_.empty()) {
    solve_to_equilibrium();
    dragged_.clear();
  }
  const std::vector<Vec3> positions = parse_points(from_to);
  const std::string from = positions.empty() ? from_to : SceneText::toml_value(positions.front());
  const bool keeps_state = dragged_ == from && !undo_.empty();
  SceneText next =
      with_moved_point(keeps_state ? SceneText(undo_.back(), file_) : SceneText(text_), from_to);
  keeps_state ? rebuild(std::move(next), progress) : change(std::move(next), progress);
  dragged_ = from;
}

void Document::set_slider(const std::string& parameter, double value, const Progress& progress) {
  if (content_->moves(parameter)) {
    content_->set(parameter, value);
    changed_sliders_.insert(parameter);
    return;
  }
  if (!changed_sliders_.empty()) solve_to_equilibrium();
  content_->check(parameter, value);
  SceneText next = text_;
  next.set_parameter(parameter, value);
  if (dragged_ == parameter)
    return rebuild(std::move(next), progress);  // same undo step as the
                                                // previous one
  change(std::move(next), progress);
  dragged_ = parameter;
}

// Performs one undoable step.
void Document::change(SceneText next, const Progress& progress) {
  std::string before = text_.text();
  rebuild(std::move(next), progress);
  undo_.push_back(std::move(before));
  redo_.clear();
}

void Document::solve_to_equilibrium() {
  try {
    content_->solve_to_equilibrium();
  } catch (const Error&) {
    commit_values();  // those of the last solution
    throw;
  }
  commit_values();
}

// The text with the current values of the sliders.
SceneText Document::text_with_values() const {
  SceneText text = text_;
  for (const std::string& name : changed_sliders_) text.set_parameter(name, content_->value(name));
  return text;
}

void Document::commit_values() {
  if (changed_sliders_.empty()) return new_load_.clear();
  SceneText next = text_with_values();
  // Dragging a load that was just added belongs to the same undo step.
  const bool of_last_step = changed_sliders_.size() == 1 && changed_sliders_.contains(new_load_);
  changed_sliders_.clear();
  new_load_.clear();
  if (next.text() == text_.text()) return;
  content_->update_text(next, file_);
  if (!of_last_step) undo_.push_back(text_.text());
  redo_.clear();
  text_ = std::move(next);
}

void Document::restore(std::vector<std::string>& from, std::vector<std::string>& to,
                       const Progress& progress) {
  if (!changed_sliders_.empty()) solve_to_equilibrium();
  if (from.empty()) return;
  std::string before = text_.text();
  rebuild(SceneText(from.back(), file_), progress);
  from.pop_back();
  to.push_back(std::move(before));
}

const EditedShape* Document::shape() const {
  return dynamic_cast<const EditedShape*>(content_.get());
}
const EditedSequence* Document::sequence() const {
  return dynamic_cast<const EditedSequence*>(content_.get());
}
const EditedMesh* Document::mesh() const { return dynamic_cast<const EditedMesh*>(content_.get()); }
SculptingSession* Document::session() const { return shape() ? shape()->session() : nullptr; }

void Document::rebuild(SceneText text, const Progress& progress) {
  content_ = next_content(text, file_, progress);
  text_ = std::move(text);
}

// The existing content, or a new one if the text is of another kind.
std::shared_ptr<DocumentContent> Document::next_content(const SceneText& text,
                                                        const std::filesystem::path& file,
                                                        const Progress& progress) const {
  const ContentKind what = content_kind(text, file);
  std::shared_ptr<DocumentContent> content = content_;
  const bool keeps_state = what == ContentKind::Sequence ? sequence() != nullptr
                           : what == ContentKind::Mesh   ? mesh() != nullptr
                                                         : shape() != nullptr;
  if (!keeps_state) {
    if (what == ContentKind::Sequence) content = std::make_shared<EditedSequence>();
    if (what == ContentKind::Mesh) content = std::make_shared<EditedMesh>();
    if (what == ContentKind::Lines) content = std::make_shared<EditedShape>();
  }
  content->rebuild(text, file, progress);
  return content;
}

DocumentView view_of(const Document& document) {
  DocumentView view;
  view.title = document.file().empty() ? "untitled" : document.file().filename().string();
  if (!document.file().empty())
    view.folder = std::filesystem::absolute(document.file()).parent_path().filename().string();
  view.text = document.text().text();
  view.changed = document.changed();
  view.can_undo = document.can_undo();
  view.can_redo = document.can_redo();
  view.problem = document.content().problem();
  for (auto& [table, values] : document.text().all_values())
    view.tables.push_back({table, std::move(values)});
  document.content().fill_view(view);
  return view;
}

// Files that a document writes.

namespace {

/// Start of the first line of a recovery file.
constexpr const char* kChangesOf = "# batten-studio: changes of ";

}  // namespace

void Document::save(const std::filesystem::path& to) {
  if (!changed_sliders_.empty()) solve_to_equilibrium();
  const std::filesystem::path& file = to.empty() ? file_ : to;
  if (file.empty())
    throw InputError("found no file name for a scene that was never saved, expected save FILE");
  const auto moved = [&](SceneText text) {
    if (file_.empty()) return relative_to_folder(std::move(text), folder_of(file));
    if (folder_of(file) == folder_of(file_)) return text;
    return with_moved_paths(std::move(text), folder_of(file_), folder_of(file));
  };
  SceneText text = moved(text_);
  // Undo and redo restore texts of the same folder.
  std::vector<std::string> undo = undo_, redo = redo_;
  for (auto* texts : {&undo, &redo})
    for (std::string& one : *texts) one = moved(SceneText(one, file_)).text();
  {
    std::optional<ReplaceableInput> own;
    std::error_code none;
    if (std::filesystem::equivalent(file, file_, none))
      own.emplace(file);
    else
      require_inputs_preserved(file);
    write_file_atomically(file, [&](std::ostream& out) { out << text.text(); });
  }
  file_ = file;
  text_ = std::move(text);
  undo_ = std::move(undo);
  redo_ = std::move(redo);
  saved_ = text_.text();
  content_->update_text(text_, file_);
}

// Files that the scene reads must not be overwritten: reopening the scene would apply its changes
// again.
void Document::require_inputs_preserved(const std::filesystem::path& written) const {
  std::error_code none;
  const std::filesystem::path folder = file_.empty() ? "" : folder_of(file_);
  with_paths(text_, [&](const std::filesystem::path& file) -> std::string {
    if (std::filesystem::equivalent(folder / file, written, none))
      throw InputError("found " + written.string() +
                       ", which this scene reads, expected another output file");
    return {};
  });
}

std::string Document::recovery_text(const std::filesystem::path& folder) const {
  const bool named = !file_.empty();
  SceneText text = text_with_values();
  // Relative paths are kept, so that recovery can restore the original paths.
  if (named)
    text =
        with_moved_paths(std::move(text), folder_of(file_), folder_of(folder / "changes"), false);
  return kChangesOf + (named ? std::filesystem::absolute(file_).string() : "") + "\n" + text.text();
}

void Document::recover(const std::filesystem::path& from, const Progress& progress) {
  const std::string bytes = read_input_file(from, "a recovery file");
  const size_t end = bytes.find('\n');
  if (!bytes.starts_with(kChangesOf) || end == std::string::npos)
    throw InputError(from.string() + ":1:1: found no recovery file, expected '" + kChangesOf +
                     "…' in the first line");
  const size_t begin = std::string(kChangesOf).size();
  const std::filesystem::path file = bytes.substr(begin, end - begin);
  SceneText text(bytes.substr(end + 1), from);
  if (!file.empty()) text = with_moved_paths(std::move(text), folder_of(from), folder_of(file));
  start(std::move(text), file, progress);
  std::error_code none;
  saved_ =
      !file.empty() && std::filesystem::exists(file, none) ? read_input_file(file, "a scene") : "";
}

ScriptReport run_script(const std::filesystem::path& script, const Progress& progress) {
  ScriptReport report;
  report.name = script.filename().string();
  Document document;
  for (const LocatedCommand& one : read_script(script)) {
    ++report.commands;
    try {
      document.apply(one.command, progress);
    } catch (const NoSolutionError& e) {
      report.warnings.push_back(one.where + e.what());
    } catch (const ConflictError& e) {
      throw ConflictError(e.conflicts(), one.where);
    } catch (const InputError& e) {
      throw InputError(one.where + e.what());
    }
    std::istringstream run_messages(document.run_messages());
    for (std::string line; std::getline(run_messages, line);)
      report.failed_checks.push_back({script_line(one.command), line});
    for (const auto kind :
         {DocumentCommand::CommandKind::Save, DocumentCommand::CommandKind::Export})
      if (one.command.kind == kind) report.files.push_back(one.command.file.string());
  }
  report.shape = document.content().rows();
  return report;
}

}  // namespace batten
