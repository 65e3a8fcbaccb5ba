#include "batten/apps/commands/documents/document.h"

#include "batten/apps/commands/documents/edited_mesh.h"
#include "batten/apps/commands/documents/edited_sequence.h"
#include "batten/apps/commands/documents/edited_shape.h"
#include "batten/apps/commands/documents/line_edits.h"
#include "batten/apps/commands/exchange/file_kinds.h"
#include "batten/apps/commands/lines/line_files.h"
#include "batten/io/files/input_file.h"
#include "batten/io/scene/scene_words.h"

namespace batten {

std::filesystem::path named_file(const std::filesystem::path& file) {
  return file.empty() ? std::filesystem::path("untitled") : file;
}

namespace {

using Verb = DocumentCommand::Verb;

std::string new_scene(const std::string& unit) {
  return "unit = " + SceneText::word(unit) + "\n\n[skin]\n";
}

/// A file as a scene anywhere names it.
std::string path_word(const std::filesystem::path& file) {
  return SceneText::word(std::filesystem::absolute(file).string());
}

/// What a scene is about: a sequence, a mesh, lines.
enum class About { Lines, Mesh, Sequence };
About about(const SceneText& text, const std::filesystem::path& file) {
  const toml::table root = parse_toml(text.text(), named_file(file), "a scene");
  if (root.contains("sequence")) return About::Sequence;
  return root.contains("mesh") || root.contains("edit") ? About::Mesh : About::Lines;
}

/// A scene around a file of lines, a mesh or a sequence.
SceneText scene_around(const std::filesystem::path& file) {
  if (file_kind(file) == FileKind::Mesh) {
    SceneText text("unit = \"mm\"\nmesh = " + path_word(file) + "\n");
    text.add("edit", "{ name = \"edit 1\" }");
    return text;
  }
  if (file_kind(file) == FileKind::Sequence)
    return SceneText("unit = \"m\"\n\n[sequence]\nfile = " + path_word(file) + "\n");
  require_input_file(file, "a file of lines");
  SceneText text(new_scene("mm"));
  text.add("lines", "{ file = " + path_word(file) + " }");
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
  told_.clear();
  const bool goes_on = command.verb == Verb::Slide || command.verb == Verb::Answer ||
                       command.verb == Verb::Step || command.verb == Verb::Settle;
  if (content_->in_motion() && !goes_on) settle();
  if (!goes_on) fresh_.clear();
  if (command.verb != Verb::Slide && command.verb != Verb::Answer && command.verb != Verb::Move)
    dragged_.clear();
  switch (command.verb) {
    case Verb::Open:
      return open(command.file, progress);
    case Verb::Recover:
      return recover(command.file, progress);
    case Verb::New:
      return start(SceneText(new_scene(command.key)), {}, progress);
    case Verb::Add:
    case Verb::Set:
    case Verb::Erase:
    case Verb::Remove:
      return edit(command, progress);
    case Verb::Move:
      return move(command.text, progress);
    case Verb::Slide:
      return slide(command.key, command.value, progress);
    case Verb::Answer:
      rests_ = content_->in_motion() || content_->answer();
      return;
    case Verb::Step:
      return content_->step(command.value);
    case Verb::Settle:
      return settle();
    case Verb::Undo:
      return go(undo_, redo_, progress);
    case Verb::Redo:
      return go(redo_, undo_, progress);
    case Verb::Save:
      return save(command.file);
    case Verb::Export:
      keep_inputs(command.file);
      if (!slid_.empty()) settle();
      told_ = content_->export_shape(command.file, progress);
      return;
    case Verb::Run:
      if (!slid_.empty()) settle();
      told_ = content_->run(command.file, progress);
      return;
  }
}

void Document::open(const std::filesystem::path& file, const Progress& progress) {
  const FileKind kind = file_kind(file);
  const bool wrapped = kind == FileKind::Mesh || kind == FileKind::Sequence ||
                       line_file_kind(file) != LineFileKind::None;
  if (!wrapped)
    return start(SceneText(input_bytes(file, "a scene, a mesh or a file of lines"), file), file,
                 progress);
  start(scene_around(file), {}, progress);
}

// A document of its own first, so that this one stays when the file is no scene.
void Document::start(SceneText text, const std::filesystem::path& file, const Progress& progress) {
  Document other;
  other.file_ = file;
  other.saved_ = text.text();
  other.become(std::move(text), progress);
  const EditedShape* shape = other.shape();
  const bool unread = shape && shape->lines().empty() && !other.content().problem().empty();
  if (unread) throw InputError(other.content().problem());
  *this = std::move(other);
}

void Document::edit(const DocumentCommand& command, const Progress& progress) {
  if (!slid_.empty()) settle();
  SceneText next = text_;
  SceneTable added;
  if (command.verb == Verb::Add) added = next.add(command.table.kind, command.text);
  if (command.verb == Verb::Set)
    next = with_one_shape(std::move(next), command.table, command.key, command.text);
  if (command.verb == Verb::Erase) next.erase(command.table, command.key);
  if (command.verb == Verb::Remove) next.remove(command.table);
  const bool fresh = added.kind == "load" && next.value(added, "value") == "0";
  change(std::move(next), progress);
  if (fresh) fresh_ = added.name;
}

// Moves from one place that follow each other are one step: each begins from the text before the first.
void Document::move(const std::string& places, const Progress& progress) {
  if (!slid_.empty()) {
    settle();
    dragged_.clear();
  }
  const std::vector<Vec3> way = listed_points(places);
  const std::string from = way.empty() ? places : point_word(way.front());
  const bool goes_on = dragged_ == from && !undo_.empty();
  SceneText next =
      with_moved_point(goes_on ? SceneText(undo_.back(), file_) : SceneText(text_), places);
  goes_on ? become(std::move(next), progress) : change(std::move(next), progress);
  dragged_ = from;
}

void Document::slide(const std::string& parameter, double value, const Progress& progress) {
  if (content_->moves(parameter)) {
    content_->set(parameter, value);
    slid_.insert(parameter);
    return;
  }
  if (!slid_.empty()) settle();
  content_->check(parameter, value);
  SceneText next = text_;
  next.set_parameter(parameter, value);
  if (dragged_ == parameter) return become(std::move(next), progress);  // one step with the last
  change(std::move(next), progress);
  dragged_ = parameter;
}

// One step that can be undone.
void Document::change(SceneText next, const Progress& progress) {
  std::string before = text_.text();
  become(std::move(next), progress);
  undo_.push_back(std::move(before));
  redo_.clear();
}

void Document::settle() {
  try {
    content_->settle();
  } catch (const Error&) {
    commit_values();  // those of the last answer that had a shape
    throw;
  }
  commit_values();
}

// The text with the values that sliders have by now.
SceneText Document::stated_values() const {
  SceneText text = text_;
  for (const std::string& name : slid_) text.set_parameter(name, content_->value(name));
  return text;
}

void Document::commit_values() {
  if (slid_.empty()) return fresh_.clear();
  SceneText next = stated_values();
  // A load that was added to be pushed: one step.
  const bool of_last_step = slid_.size() == 1 && slid_.contains(fresh_);
  slid_.clear();
  fresh_.clear();
  if (next.text() == text_.text()) return;
  content_->restate(next, file_);
  if (!of_last_step) undo_.push_back(text_.text());
  redo_.clear();
  text_ = std::move(next);
}

void Document::go(std::vector<std::string>& from, std::vector<std::string>& to,
                  const Progress& progress) {
  if (!slid_.empty()) settle();
  if (from.empty()) return;
  std::string before = text_.text();
  become(SceneText(from.back(), file_), progress);
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

void Document::become(SceneText text, const Progress& progress) {
  content_ = next_content(text, file_, progress);
  text_ = std::move(text);
}

// The content there goes on, or is replaced where the text is of another kind.
std::shared_ptr<DocumentContent> Document::next_content(const SceneText& text,
                                                        const std::filesystem::path& file,
                                                        const Progress& progress) const {
  const About what = about(text, file);
  std::shared_ptr<DocumentContent> content = content_;
  const bool goes_on = what == About::Sequence ? sequence() != nullptr
                       : what == About::Mesh   ? mesh() != nullptr
                                               : shape() != nullptr;
  if (!goes_on) {
    if (what == About::Sequence) content = std::make_shared<EditedSequence>();
    if (what == About::Mesh) content = std::make_shared<EditedMesh>();
    if (what == About::Lines) content = std::make_shared<EditedShape>();
  }
  content->become(text, file, progress);
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
  document.content().look_at(view);
  return view;
}

}  // namespace batten
