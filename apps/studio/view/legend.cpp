#include "batten/apps/studio/view/legend.h"

#include <vtkLookupTable.h>
#include <vtkRenderer.h>
#include <vtkScalarBarActor.h>
#include <vtkTextActor.h>
#include <vtkTextProperty.h>

namespace batten::studio {

Legend::Legend(vtkRenderer* renderer) {
  constexpr int words_size = 15, numbers_size = 13;
  text_->GetPositionCoordinate()->SetCoordinateSystemToNormalizedViewport();
  text_->SetPosition(0.015, 0.965);
  text_->GetTextProperty()->SetVerticalJustificationToTop();
  text_->GetTextProperty()->SetFontSize(words_size);
  scale_->UnconstrainedFontSizeOn();
  scale_->SetNumberOfLabels(5);
  scale_->SetLabelFormat("%.3g");
  scale_->SetMaximumWidthInPixels(70);
  scale_->SetPosition(0.012, 0.06);
  scale_->SetHeight(0.42);
  scale_->SetWidth(0.09);
  scale_->GetLabelTextProperty()->SetFontSize(numbers_size);
  scale_->GetLabelTextProperty()->ItalicOff();
  scale_->GetLabelTextProperty()->BoldOff();
  scale_->GetLabelTextProperty()->ShadowOff();
  scale_->VisibilityOff();
  text_->PickableOff();
  scale_->PickableOff();
  title_->GetPositionCoordinate()->SetCoordinateSystemToNormalizedViewport();
  title_->SetPosition(0.015, 0.53);
  title_->GetTextProperty()->SetFontSize(numbers_size);
  title_->PickableOff();
  renderer->AddActor2D(title_);
  renderer->AddActor2D(text_);
  renderer->AddActor2D(scale_);
}

Legend::~Legend() = default;

void Legend::set_palette(const Palette& palette) {
  const Rgb& c = palette.text;
  text_->GetTextProperty()->SetColor(c[0], c[1], c[2]);
  title_->GetTextProperty()->SetColor(c[0], c[1], c[2]);
  scale_->GetLabelTextProperty()->SetColor(c[0], c[1], c[2]);
}

void Legend::set_text(const std::string& overlay_text) { text_->SetInput(overlay_text.c_str()); }

void Legend::set_scale(vtkLookupTable* table, const std::string& title) {
  scale_->SetVisibility(table != nullptr);
  if (table) scale_->SetLookupTable(table);
  title_->SetInput(table ? title.c_str() : "");
}

}  // namespace batten::studio
