// SPDX-License-Identifier: MPL-2.0
// An open document: a scene's text, its results, and the edit history. Used by windows and scripts.
#pragma once

#include <filesystem>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "batten/apps/documents/document_command.h"
#include "batten/apps/documents/document_content.h"
#include "batten/core/progress.h"
#include "batten/io/report/run_report.h"

namespace batten {

class EditedMesh;
class EditedSequence;
class SculptingSession;
class EditedShape;

/// A scene under edit: curves and their surface, a mesh, or a mesh sequence. Its text is the only
/// state; everything else is derived from the text, and recomputed as far as an edit requires
/// (edited_shape.h, edited_mesh.h, edited_sequence.h).
///
/// undo() and redo() restore texts, without limit. The same commands on the same files give
/// bit-identical results.
///
/// A command either succeeds, or throws and leaves the document unchanged: for text that is no
/// scene, or conflicting constraints, say. Lines that do not form a surface (yet) are no error:
/// content().problem() explains what is missing. Not thread-safe: only one thread at a time may
/// call it.
class Document {
 public:
  /// An empty scene in millimetres.
  Document();
  ~Document();
  Document(Document&&) noexcept;
  Document& operator=(Document&&) noexcept;

  /// Executes a command. Throws InputError, ConflictError, NoSolutionError, CancelledError. If
  /// `solve` finds no solution, the document returns to the last values that had one.
  void apply(const DocumentCommand& command, const Progress& progress = {});

  /// The text of the scene.
  const SceneText& text() const { return text_; }
  const std::filesystem::path& file() const { return file_; }  ///< empty: never saved
  /// True if the text differs from the file, or sliders have moved since.
  bool changed() const { return text_.text() != saved_ || !changed_sliders_.empty(); }
  /// True if undo() is possible.
  bool can_undo() const { return !undo_.empty() || !changed_sliders_.empty(); }
  /// True if redo() is possible.
  bool can_redo() const { return !redo_.empty(); }
  /// True if the last solution is converged.
  bool is_at_rest() const { return at_rest_; }
  /// The text as it would be in a file in `folder` (with adapted paths), preceded by a line with
  /// the document's file name. The command `recover` reads it.
  std::string recovery_text(const std::filesystem::path& folder) const;
  /// Messages of the last `run` or `export`: failed checks and warnings, one per line.
  const std::string& run_messages() const { return run_messages_; }

  /// The contents derived from the text.
  const DocumentContent& content() const { return *content_; }
  bool draw(Frame& frame) { return content_->draw(frame); }
  std::shared_ptr<const StressView> stress(Analysis what) { return content_->stress(what); }
  /// Shows another frame (0-based) of a sequence. This changes the display, not the text.
  void show_frame(int frame) { content_->show_frame(frame); }
  /// The content by its type, or null.
  const EditedShape* shape() const;
  const EditedMesh* mesh() const;
  const EditedSequence* sequence() const;
  /// The sculpting session of a shape, or null.
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
  std::vector<std::string> undo_, redo_;   // previous and undone texts
  std::set<std::string> changed_sliders_;  // parameters changed since the last `solve`
  std::string dragged_;                    // the parameter or point edited by the last undo step
  std::string new_load_;                   // load added by the last undo step, still with value 0
  bool at_rest_ = true;
};

/// Creates the view of a document. Cost: O(display lines + tables · bytes).
DocumentView view_of(const Document& document);

// Implements `batten run-script`.

/// Report of a script.
struct ScriptReport : RunReport {
  int commands = 0;
  std::string shape;  ///< the final document, several lines of a summary
};

/// Executes the commands of a script (document_command.h) on a new document. A shape without a
/// solution returns to the last one that had one, as in the window where the script was recorded,
/// and adds a warning. Any other rejected command ends the script. Failed checks of `run` and
/// `export` are in `failed_checks`. Throws InputError, ConflictError and NoSolutionError that begin
/// with the script's line, and CancelledError.
ScriptReport run_script(const std::filesystem::path& script, const Progress& progress = {});

}  // namespace batten
