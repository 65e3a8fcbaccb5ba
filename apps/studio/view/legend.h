// Words and a scale of colours over the view.
#pragma once

#include <vtkNew.h>

#include <array>
#include <string>

#include "batten/apps/studio/view/shape_colours.h"

class vtkRenderer;
class vtkScalarBarActor;
class vtkTextActor;

namespace batten::studio {

class Legend {
 public:
  explicit Legend(vtkRenderer* renderer);
  ~Legend();
  void set_palette(const Palette& palette);
  void set_text(const std::string& overlay_text);
  /// What the colours of a table stand for, with a title; null: no scale.
  void set_scale(vtkLookupTable* table, const std::string& title);

 private:
  vtkNew<vtkTextActor> text_, title_;
  vtkNew<vtkScalarBarActor> scale_;
};

}  // namespace batten::studio
