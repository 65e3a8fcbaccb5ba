// SPDX-License-Identifier: MPL-2.0
// Interface to the contents of a document: a surface, a mesh, or a mesh sequence.
#pragma once

#include <filesystem>
#include <string>

#include "batten/apps/documents/document_view.h"
#include "batten/core/progress.h"
#include "batten/io/scene/scene_text.h"
#include "batten/sculpting/session/session_results.h"

namespace batten {

/// A surface point of a document: the one nearest to a point of the current shape.
struct PickedPoint {
  std::string region;
  /// Current position and normal.
  Vec3 present = Vec3::Zero(), normal = Vec3::Zero();
  /// Its position on the unloaded surface: the value of `at` in a scene.
  Vec3 unloaded = Vec3::Zero();
};

/// Contents of a Document, derived from its text. Each function either succeeds, or throws and
/// leaves everything unchanged.
class DocumentContent {
 public:
  virtual ~DocumentContent() = default;

  /// Derives the contents from the text, from scratch or by updating existing contents. `file`:
  /// name for messages; paths are relative to its folder. If there were no contents before, a
  /// failure is no error: problem() then explains it. Throws InputError, ConflictError,
  /// NoSolutionError, CancelledError.
  virtual void rebuild(const SceneText& text, const std::filesystem::path& file,
                       const Progress& progress) = 0;
  /// Notifies that the text now matches the contents: it received changed values, or was saved to
  /// `file`.
  virtual void update_text(const SceneText& text, const std::filesystem::path& file) = 0;
  /// Why there are no contents; empty if there are some, or nothing to derive them from.
  const std::string& problem() const { return problem_; }

  /// True if a parameter changes the contents without a change of the text.
  virtual bool moves(const std::string&) const { return false; }
  /// Throws InputError if the scene does not have this parameter, or does not permit this value.
  virtual void check(const std::string& parameter, double value) const = 0;
  /// Sets a parameter; the shape follows on solve_preview() or solve_to_equilibrium().
  virtual void set(const std::string&, double) {}
  /// Current value of a parameter.
  virtual double value(const std::string&) const { return 0; }
  /// Quick update for changed values; true if the shape is converged.
  virtual bool solve_preview() { return true; }
  /// Solves to equilibrium, and ends a motion. On an exception, the last values with a solution are
  /// restored.
  virtual void solve_to_equilibrium() {}
  /// Performs one time step of a motion from the current shape. A different step length starts a
  /// new motion, with velocity 0. Throws InputError if nothing can move, or for an invalid length.
  virtual void step(double) {
    throw InputError("found no surface for a motion, expected a scene with a surface");
  }
  /// True during a motion.
  virtual bool in_motion() const { return false; }

  /// Shows another frame of a sequence; 0-based.
  virtual void show_frame(int) {}
  /// Fills a frame for display; false if there is nothing to draw.
  virtual bool draw(Frame& frame) = 0;
  /// The surface point nearest to a point. Throws InputError if there is no surface.
  virtual PickedPoint nearest_point(const Vec3&) const {
    throw InputError("found no surface, expected a scene with a surface");
  }
  /// Stresses or natural modes of the current shape; null if the scene requests none. If the
  /// analysis fails, StressView::problem explains why.
  virtual std::shared_ptr<const StressView> stress(Analysis) { return nullptr; }
  /// Adds the contents to a view, except the text.
  virtual void fill_view(DocumentView& view) const = 0;
  /// Summary of a few lines.
  virtual std::string rows() const = 0;

  /// Writes all files that the scene requests. The result lists failed checks, one per line.
  virtual std::string run(const std::filesystem::path& folder, const Progress& progress) = 0;
  /// Writes the current shape to a file. The result lists failed checks, one per line.
  virtual std::string export_shape(const std::filesystem::path& file, const Progress& progress) = 0;

 protected:
  std::string problem_;
};

/// Name of a scene's file for messages.
std::filesystem::path named_file(const std::filesystem::path& file);

}  // namespace batten
