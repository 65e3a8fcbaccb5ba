// What the text of a document makes: a shape on lines, or a mesh that is edited.
#pragma once

#include <filesystem>
#include <string>

#include "batten/apps/commands/documents/document_view.h"
#include "batten/core/progress.h"
#include "batten/io/scene/scene_text.h"
#include "batten/sculpting/session/session_results.h"

namespace batten {

/// A place of a document's surface: the one nearest to a point of the present shape.
struct SurfacePoint {
  std::string region;
  Vec3 present = Vec3::Zero(), normal = Vec3::Zero();
  /// Where it lies without loads: what a scene says as `at`.
  Vec3 unloaded = Vec3::Zero();
};

/// What a Document has made of its text. Each function either does what it says or throws and leaves
/// all as it was.
class DocumentContent {
 public:
  virtual ~DocumentContent() = default;

  /// Makes what the text says, anew or as a change of what is there. `file` names it in messages;
  /// paths in it are relative to its folder. What cannot be made is no error where nothing was there
  /// before: then problem() says what is missing. Throws InputError, ConflictError, NoSolutionError,
  /// CancelledError.
  virtual void rebuild(const SceneText& text, const std::filesystem::path& file,
                       const Progress& progress) = 0;
  /// The text states by now what is there: values that moved, or a file that it was saved to.
  virtual void update_text(const SceneText& text, const std::filesystem::path& file) = 0;
  /// Why nothing could be made, in words; "" where something is there, or nothing to make it of.
  const std::string& problem() const { return problem_; }

  /// Whether a parameter moves what is there, without a change of the text.
  virtual bool moves(const std::string&) const { return false; }
  /// Throws InputError when the scene has no such parameter, or not this value for it.
  virtual void check(const std::string& parameter, double value) const = 0;
  virtual void set(const std::string&, double) {}
  virtual double value(const std::string&) const { return 0; }
  /// A quick answer to values that were set; whether it is at rest.
  virtual bool solve_preview() { return true; }
  /// The shape at rest; a motion ends. Throws: then it has the last values that had a shape.
  virtual void solve_to_equilibrium() {}
  /// One step of a motion from the present shape. One of another length than the last begins a new
  /// motion, with the velocity 0. Throws InputError where nothing can move, and for no length.
  virtual void step(double) {
    throw InputError("found nothing that can move, expected a surface on lines");
  }
  virtual bool in_motion() const { return false; }

  /// Shows another frame of a sequence, counted from 0.
  virtual void show_frame(int) {}
  /// Fills a frame; false where there is nothing to draw.
  virtual bool draw(Frame& frame) = 0;
  /// Throws InputError where there is no surface.
  virtual SurfacePoint nearest_point(const Vec3&) const {
    throw InputError("found no surface on lines, expected one to act on");
  }
  /// Stresses or modes of the present shape; null where the scene asks for none. What cannot be
  /// analysed is told in words.
  virtual std::shared_ptr<const StressView> stress(Analysis) { return nullptr; }
  /// Adds to a view what is there, beside the text.
  virtual void fill_view(DocumentView& view) const = 0;
  /// A few rows for a summary.
  virtual std::string rows() const = 0;

  /// Makes all files that the scene asks for, or writes the present shape; what was missed, one a line.
  virtual std::string run(const std::filesystem::path& folder, const Progress& progress) = 0;
  virtual std::string export_shape(const std::filesystem::path& file, const Progress& progress) = 0;

 protected:
  std::string problem_;
};

/// The file of a scene in messages.
std::filesystem::path named_file(const std::filesystem::path& file);

}  // namespace batten
