// SPDX-License-Identifier: MPL-2.0
// Document contents of a sequence scene: a mesh sequence with its operations.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "batten/apps/documents/document_content.h"
#include "batten/scenes/sequences/sequence_steps.h"

namespace batten {

/// The frames of a sequence scene after each operation, all in memory: 24 bytes per node, frame and
/// operation. The text is a scene of `batten sequence`, and the frames equal its output. A change
/// of the text recomputes all operations from the first changed one.
class EditedSequence : public DocumentContent {
 public:
  EditedSequence();
  ~EditedSequence() override;
  void rebuild(const SceneText& text, const std::filesystem::path& file,
               const Progress& progress) override;
  void update_text(const SceneText& text, const std::filesystem::path& file) override;
  void check(const std::string& parameter, double value) const override;
  void show_frame(int frame) override;
  bool draw(Frame& frame) override;
  void fill_view(DocumentView& view) const override;
  std::string rows() const override;
  std::string run(const std::filesystem::path& folder, const Progress& progress) override;
  std::string export_shape(const std::filesystem::path& file, const Progress& progress) override;

  /// The frames after the last operation.
  const MeshSequence& frames() const;

 private:
  struct Sections;
  struct State;
  SequenceScene scene_;
  std::unique_ptr<State> made_;
  int frame_ = 0;  // shown frame, 0-based
};

}  // namespace batten
