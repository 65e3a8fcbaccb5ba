// A deforming mesh that is edited.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "batten/apps/commands/documents/document_content.h"
#include "batten/apps/commands/documents/mesh_display.h"
#include "batten/apps/commands/sequences/sequence_steps.h"

namespace batten {

/// Frames, and the steps of a sequence scene one after the other, all in memory: 24 bytes a node,
/// frame and step. The text is that of `batten sequence`, and the frames are what that would write. A
/// change of the text does the steps again from the first that it changes on.
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

  /// The frames after the last step.
  const MeshSequence& frames() const;

 private:
  struct Sections;
  struct State;
  SequenceScene scene_;
  std::unique_ptr<State> made_;
  int frame_ = 0;  // that is shown, from 0
};

}  // namespace batten
