#include "batten/apps/commands/documents/document.h"

#include <algorithm>
#include <fstream>

#include "batten/apps/commands/lines/line_files.h"
#include "batten/apps/commands/lines/scene_lines.h"
#include "batten/apps/commands/shapes/run_scene.h"
#include "batten/io/files/input_file.h"
#include "batten/io/files/whole_file.h"
#include "batten/io/scene/read_scene.h"
#include "batten/skinning/model/model_projector.h"

namespace batten {
namespace {

/// Models that are kept for undo.
constexpr size_t kLately = 4;

/// The file of a scene in messages.
std::filesystem::path named(const std::filesystem::path& file) {
  return file.empty() ? std::filesystem::path("untitled") : file;
}

std::string new_scene(const std::string& unit) {
  return "unit = " + SceneText::word(unit) + "\n\n[network]\n\n[skin]\n";
}

/// A file as a scene anywhere names it.
std::string path_word(const std::filesystem::path& file) {
  return SceneText::word(std::filesystem::absolute(file).string());
}

}  // namespace

Document::Document() : text_(new_scene("mm")), saved_(text_.text()) {
  scene_ = parse_scene(text_.text(), named({}), false);
  parts_ = parts_of(text_);
}
Document::~Document() = default;
Document::Document(Document&&) noexcept = default;
Document& Document::operator=(Document&&) noexcept = default;

void Document::apply(const DocumentCommand& command, const Progress& progress) {
  using Verb = DocumentCommand::Verb;
  told_.clear();
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
    case Verb::Slide:
      return slide(command.key, command.value, progress);
    case Verb::Answer:
      if (session_) answer_ = session_->answer();
      return;
    case Verb::Settle:
      return settle();
    case Verb::Undo:
      return go(undo_, redo_, progress);
    case Verb::Redo:
      return go(redo_, undo_, progress);
    case Verb::Save:
      return save(command.file);
    case Verb::Export:
      return export_shape(command.file, progress);
    case Verb::Run: {
      if (!slid_.empty()) settle();
      const Report report = run_scene(scene_, command.file, progress);
      for (const MissedPromise& missed : report.missed)
        told_ += missed.what + ": " + missed.detail + "\n";
      return;
    }
  }
}

void Document::open(const std::filesystem::path& file, const Progress& progress) {
  if (line_file_kind(file) == LineFileKind::None)
    return start(SceneText(input_bytes(file, "a scene or a file of lines"), file), file, progress);
  require_input_file(file, "a file of lines");
  SceneText text(new_scene("mm"));
  text.add("lines", "{ file = " + path_word(file) + " }");
  start(std::move(text), {}, progress);
  saved_ = "";
}

void Document::start(SceneText text, const std::filesystem::path& file, const Progress& progress) {
  // A document of its own first, so that this one stays when the file is no scene.
  Document other;
  other.file_ = file;
  other.scene_ = parse_scene(text.text(), named(file), false);
  other.parts_ = parts_of(text);
  other.text_ = std::move(text);
  other.saved_ = other.text_.text();
  other.remake(other.scene_, other.parts_, true, progress);
  *this = std::move(other);
}

void Document::edit(const DocumentCommand& command, const Progress& progress) {
  using Verb = DocumentCommand::Verb;
  if (!slid_.empty()) settle();
  SceneText next = text_;
  if (command.verb == Verb::Add) next.add(command.table.kind, command.text);
  if (command.verb == Verb::Set) next.set(command.table, command.key, command.text);
  if (command.verb == Verb::Erase) next.erase(command.table, command.key);
  if (command.verb == Verb::Remove) next.remove(command.table);
  std::string before = text_.text();
  become(std::move(next), progress);
  undo_.push_back(std::move(before));
  redo_.clear();
}

void Document::slide(const std::string& parameter, double value, const Progress& progress) {
  if (session_ && is_live(scene_, parameter)) {
    session_->set(parameter, value);
    slid_.insert(parameter);
    return;
  }
  if (!slid_.empty()) settle();
  Scene(scene_).set(parameter, value, "");  // whether it may be
  SceneText next = text_;
  next.set_parameter(parameter, value);
  std::string before = text_.text();
  become(std::move(next), progress);
  undo_.push_back(std::move(before));
  redo_.clear();
}

void Document::settle() {
  if (!session_) return;
  try {
    answer_ = session_->settle();
  } catch (const NoSolutionError&) {
    commit_values();  // those of the last answer that converged
    throw;
  }
  commit_values();
}

void Document::commit_values() {
  if (slid_.empty()) return;
  SceneText next = text_;
  for (const std::string& name : slid_)
    next.set_parameter(name, session_->parameters().value(name));
  slid_.clear();
  if (next.text() == text_.text()) return;
  undo_.push_back(text_.text());
  redo_.clear();
  scene_ = parse_scene(next.text(), named(file_), false);
  parts_ = parts_of(next);
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

void Document::become(SceneText text, const Progress& progress) {
  const Scene scene = parse_scene(text.text(), named(file_), false);
  const SceneParts parts = parts_of(text);
  const bool same_model = model_ && parts.model == parts_.model;
  bool made = false;
  if (session_ && same_model) try {
      made = go_on(scene, parts);
    } catch (const Error&) {
      remake(scene_, parts_, true, progress);  // as it was
      throw;
    }
  if (!made) remake(scene, parts, !(same_model && session_), progress);
  scene_ = scene;
  parts_ = parts;
  text_ = std::move(text);
}

bool Document::go_on(const Scene& scene, const SceneParts& parts) {
  std::vector<std::string> less, more;
  for (const auto& [name, words] : parts_.acting) {
    const auto found = parts.acting.find(name);
    if (found == parts.acting.end() || found->second != words) less.push_back(name);
  }
  for (const auto& [name, words] : parts.acting) {
    const auto found = parts_.acting.find(name);
    if (found == parts_.acting.end() || found->second != words) more.push_back(name);
  }
  // One change alone: it happens or the session is as it was.
  if (less.size() + more.size() > 1) return false;
  if (!more.empty()) {
    for (const SceneLoad& load : scene.loads)
      if (more.front() == "load " + load.name && load.over_time.empty() &&
          (load.type == SceneLoad::Type::Point || load.type == SceneLoad::Type::Pulls)) {
        add_load(*session_, scene, model_->model.made, load, start_.held);
        take_values(scene);
        return true;
      }
    return false;
  }
  if (!less.empty()) {
    const size_t blank = less.front().find(' ');
    const std::string kind = less.front().substr(0, blank);
    if (kind != "load" && kind != "weight") return false;
    session_->remove(less.front().substr(blank + 1));
  }
  take_values(scene);
  return true;
}

void Document::take_values(const Scene& scene) {
  for (const NamedValue& p : scene.named_values()) {
    if (!p.follows.empty() || !p.over_time.empty() || !session_->parameters().has(p.name)) continue;
    if (session_->parameters().value(p.name) != p.value) session_->set(p.name, p.value);
  }
  answer_ = session_->settle();
}

std::shared_ptr<const DocumentModel> Document::model_for(const Scene& scene, const std::string& of,
                                                         const Progress& progress) {
  for (auto it = lately_.begin(); it != lately_.end(); ++it)
    if ((*it)->of == of) {
      lately_.splice(lately_.begin(), lately_, it);
      lines_ = lately_.front()->lines;
      return lately_.front();
    }
  progress.at("lines", 0);
  auto made = std::make_shared<DocumentModel>();
  made->of = of;
  made->lines = faired_lines(scene, progress).lines;
  lines_ = made->lines;
  made->model = sculpt_model(make_model(scene, made->lines, progress), scene, progress);
  lately_.push_front(made);
  if (lately_.size() > kLately) lately_.pop_back();
  return made;
}

void Document::remake(const Scene& scene, const SceneParts& parts, bool may_fail,
                      const Progress& progress) {
  const std::vector<CharacterLine> lines_before = lines_;
  std::shared_ptr<const DocumentModel> model;
  std::unique_ptr<SculptingSession> session;
  SessionStart start;
  Answer answer;
  std::string problem;
  try {
    lines_.clear();
    if (!scene.lines.empty()) {
      model = model_for(scene, parts.model, progress);
      progress.at("session", 0);
      session = std::make_unique<SculptingSession>(
          make_session(*model->model.layout, scene, model->model.made, Expected::many_factors,
                       progress, &start, model->model.fair.rest));
      answer = session->settle();
    }
  } catch (const CancelledError&) {
    lines_ = lines_before;
    throw;
  } catch (const Error& e) {
    if (!may_fail) {
      lines_ = lines_before;
      throw;
    }
    problem = e.what();
    session.reset();
  }
  model_ = std::move(model);
  session_ = std::move(session);
  start_ = std::move(start);
  answer_ = answer;
  problem_ = std::move(problem);
}

Document::Place Document::place(const Vec3& near) const {
  if (!session_) throw InputError("found no surface, expected one to act on");
  const ModelLayout& layout = session_->layout();
  const ModelProjector present(layout, session_->dofs());
  const ModelProjector::Nearest found = present.nearest_inside(near);
  const Location where = layout.in_model(found.at.region, found.where);
  const SurfaceJet jet = layout.surface(session_->dofs()).jet(where);
  return {layout.region(found.at.region).name(), jet.x, jet.normal(),
          layout.surface(start_.held).position(where)};
}

}  // namespace batten
