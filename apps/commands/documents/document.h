// An open scene: its text, what it makes, and the history of edits. What a window or a script works on.
#pragma once

#include <filesystem>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "batten/apps/commands/documents/document_command.h"
#include "batten/apps/commands/documents/document_content.h"
#include "batten/core/progress.h"
#include "batten/io/report/run_report.h"

namespace batten {

class EditedMesh;
class EditedSequence;
class SculptingSession;
class EditedShape;

/// A scene that is worked on: lines and their skin, a mesh that is edited, or a
/// deforming one. Its text is all there is
/// to it: everything else is made from the text, again as far as an edit asks for it (edited_shape.h,
/// edited_mesh.h).
///
/// undo() and redo() put texts back, without limit. The same commands on the same files give the same
/// bits.
///
/// A command either happens or throws and leaves the document as it was: text that is no scene,
/// constraints in conflict. Lines that make no surface (yet) are no error: content().problem() says
/// what is missing. One thread at a time may call it.
class Document {
 public:
  /// An empty scene in millimetres.
  Document();
  ~Document();
  Document(Document&&) noexcept;
  Document& operator=(Document&&) noexcept;

  /// Does a command. Throws InputError, ConflictError, NoSolutionError, CancelledError. After a
  /// settle without solution the document has the last values that had one.
  void apply(const DocumentCommand& command, const Progress& progress = {});

  const SceneText& text() const { return text_; }
  const std::filesystem::path& file() const { return file_; }  ///< empty: never saved
  /// Whether the text differs from the file, values of sliders that move included.
  bool changed() const { return text_.text() != saved_ || !changed_sliders_.empty(); }
  bool can_undo() const { return !undo_.empty() || !changed_sliders_.empty(); }
  bool can_redo() const { return !redo_.empty(); }
  /// Whether the last answer was at rest.
  bool is_at_rest() const { return at_rest_; }
  /// The text as a file in `folder` would have it, below a line that names the document's file: what
  /// `recover` reads.
  std::string recovery_text(const std::filesystem::path& folder) const;
  /// What came of `run` and `export`: misses and warnings, one a line.
  const std::string& run_messages() const { return run_messages_; }

  const DocumentContent& content() const { return *content_; }
  bool draw(Frame& frame) { return content_->draw(frame); }
  std::shared_ptr<const StressView> stress(Analysis what) { return content_->stress(what); }
  /// Another frame of a sequence, counted from 0: of what is shown, not of the text.
  void show_frame(int frame) { content_->show_frame(frame); }
  /// The content as what it is, or null.
  const EditedShape* shape() const;
  const EditedMesh* mesh() const;
  const EditedSequence* sequence() const;
  /// The session of a shape, or null.
  SculptingSession* session() const;

 private:
  void open(const std::filesystem::path& file, const Progress& progress);
  void start(SceneText text, const std::filesystem::path& file, const Progress& progress);
  void edit(const DocumentCommand& command, const Progress& progress);
  void move(const std::string& from_to, const Progress& progress);
  void set_slider(const std::string& parameter, double value, const Progress& progress);
  void change(SceneText next, const Progress& progress);
  void solve_to_equilibrium();
  SceneText text_with_values() const;
  void commit_values();
  void restore(std::vector<std::string>& from, std::vector<std::string>& to,
               const Progress& progress);
  void rebuild(SceneText text, const Progress& progress);
  std::shared_ptr<DocumentContent> next_content(const SceneText& text,
                                                const std::filesystem::path& file,
                                                const Progress& progress) const;
  void save(const std::filesystem::path& file);
  void require_inputs_preserved(const std::filesystem::path& written) const;
  void recover(const std::filesystem::path& file, const Progress& progress);

  SceneText text_;
  std::filesystem::path file_;
  std::string saved_;
  std::shared_ptr<DocumentContent> content_;
  std::string run_messages_;
  std::vector<std::string> undo_, redo_;   // texts
  std::set<std::string> changed_sliders_;  // parameters that moved since the last settle
  std::string dragged_;   // the parameter or point that the last step's edits were of
  std::string new_load_;  // the load of the last step, which has no strength yet
  bool at_rest_ = true;
};

/// Looks at a document. O(facets' lines + tables · bytes).
DocumentView view_of(const Document& document);


// Does the work of `batten run-script`.

struct ScriptReport : RunReport {
  int commands = 0;
  std::string shape;  ///< what the document is in the end, rows of a summary
};

/// Does the commands of a script (document_command.h) on a document, one after the other. A shape
/// that has no solution goes back to the last one that had, as in the window where the script was
/// recorded, and is told in `warnings`; anything else that is refused ends the script. Misses of
/// `run` and `export` are in `failed_checks`. Throws InputError, ConflictError, NoSolutionError that begin
/// with the script's line, CancelledError.
ScriptReport run_script(const std::filesystem::path& script, const Progress& progress = {});

}  // namespace batten
