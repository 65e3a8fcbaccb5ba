// An open scene: its text, what it makes, and the history of edits. What a window or a script works on.
#pragma once

#include <filesystem>
#include <list>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "batten/apps/commands/documents/document_command.h"
#include "batten/apps/commands/shapes/make_session.h"
#include "batten/apps/commands/shapes/make_shape.h"
#include "batten/io/scene/scene_parts.h"

namespace batten {

/// What a document's lines make, before anything acts on it.
struct DocumentModel {
  std::string of;  ///< SceneParts::model
  std::vector<CharacterLine> lines;
  SculptModel model;
};

/// A scene that is being worked on. Its text is all there is to it: everything else is made from the
/// text, again as far as an edit asks for it,
///
///     a value                        the session goes on: a pair of triangular solves or a few
///     a point load or pull more,     the session goes on
///       a load or weight less
///     other loads, constraints, …    a new session on the same model
///     lines, joins, [skin]           a new model
///
/// undo() and redo() put texts back, without limit; models that were made lately are kept. The same
/// commands on the same files give the same bits.
///
/// A command either happens or throws and leaves the document as it was: text that is no scene,
/// constraints in conflict. Lines that make no surface (yet) are no error: `problem` says what is
/// missing, and there is no session until they do. One thread at a time may call it.
class Document {
 public:
  /// An empty network in millimetres.
  Document();
  ~Document();
  Document(Document&&) noexcept;
  Document& operator=(Document&&) noexcept;

  /// Does a command. Throws InputError, ConflictError, NoSolutionError, CancelledError. After a
  /// settle without solution the document has the last values that had one.
  void apply(const DocumentCommand& command, const Progress& progress = {});

  const SceneText& text() const { return text_; }
  const Scene& scene() const { return scene_; }
  const std::filesystem::path& file() const { return file_; }  ///< empty: never saved
  /// Whether the text differs from the file, values of sliders that move included.
  bool changed() const { return text_.text() != saved_ || !slid_.empty(); }
  bool can_undo() const { return !undo_.empty() || !slid_.empty(); }
  bool can_redo() const { return !redo_.empty(); }
  /// Why there is no surface, in words; "" where there is one, or nothing to make one of.
  const std::string& problem() const { return problem_; }
  /// The lines, fair ones where [[fair]] asks for it; those of the text as far as they can be read.
  const std::vector<CharacterLine>& lines() const { return lines_; }
  const DocumentModel* model() const { return model_.get(); }
  SculptingSession* session() const { return session_.get(); }
  /// Whether the last answer converged.
  bool at_rest() const { return answer_.converged; }
  /// The text as a file in `folder` would have it, below a line that names the document's file: what
  /// `recover` reads.
  std::string recovery_text(const std::filesystem::path& folder) const;
  /// What came of `run` and `export`: misses and warnings, one a line.
  const std::string& told() const { return told_; }

  /// A place of the surface: the one nearest to a point of the present shape.
  struct Place {
    std::string region;
    Vec3 present = Vec3::Zero(), normal = Vec3::Zero();
    /// Where it lies without loads: what a scene says as `at`.
    Vec3 held = Vec3::Zero();
  };
  /// Throws InputError when there is no surface.
  Place place(const Vec3& near) const;

 private:
  void open(const std::filesystem::path& file, const Progress& progress);
  void start(SceneText text, const std::filesystem::path& file, const Progress& progress);
  void edit(const DocumentCommand& command, const Progress& progress);
  void slide(const std::string& parameter, double value, const Progress& progress);
  void settle();
  void commit_values();
  void go(std::vector<std::string>& from, std::vector<std::string>& to, const Progress& progress);
  void become(SceneText text, const Progress& progress);
  void remake(const Scene& scene, const SceneParts& parts, bool may_fail, const Progress& progress);
  bool go_on(const Scene& scene, const SceneParts& parts);
  void take_values(const Scene& scene);
  std::shared_ptr<const DocumentModel> model_for(const Scene& scene, const std::string& of,
                                                 const Progress& progress);
  void save(const std::filesystem::path& file);
  void recover(const std::filesystem::path& file, const Progress& progress);
  void export_shape(const std::filesystem::path& file, const Progress& progress);

  SceneText text_;
  std::filesystem::path file_;
  std::string saved_;
  Scene scene_;
  SceneParts parts_;
  std::vector<CharacterLine> lines_;
  std::shared_ptr<const DocumentModel> model_;
  std::unique_ptr<SculptingSession> session_;
  SessionStart start_;
  Answer answer_;
  std::string problem_, told_;
  std::vector<std::string> undo_, redo_;  // texts
  std::set<std::string> slid_;            // parameters that moved since the last settle
  std::list<std::shared_ptr<const DocumentModel>> lately_;
};

}  // namespace batten
