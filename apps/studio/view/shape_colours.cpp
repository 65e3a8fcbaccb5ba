// SPDX-License-Identifier: MPL-2.0
#include "batten/apps/studio/view/shape_colours.h"

#include <vtkLookupTable.h>
#include <vtkMath.h>
#include <vtkNew.h>
#include <vtkRenderer.h>
#include <vtkScalarBarActor.h>
#include <vtkTextActor.h>
#include <vtkTextProperty.h>
#include <algorithm>
#include <cmath>

namespace batten::studio {

vtkSmartPointer<vtkLookupTable> stripes(double low, double high, int count, const Rgb& a,
                                        const Rgb& b) {
  vtkNew<vtkLookupTable> table;
  table->SetNumberOfTableValues(count);
  table->SetTableRange(low, high);
  for (int i = 0; i < count; ++i) {
    const auto& c = i % 2 == 0 ? a : b;
    table->SetTableValue(i, c[0], c[1], c[2]);
  }
  return table.Get();
}

vtkSmartPointer<vtkLookupTable> region_colours(int count) {
  vtkNew<vtkLookupTable> table;
  table->SetNumberOfTableValues(std::max(1, count));
  table->SetTableRange(0, std::max(1, count) - 1);
  for (int i = 0; i < std::max(1, count); ++i) {
    const double hue = std::fmod(0.58 + i * 0.381966, 1.0);
    double rgb[3];
    const double hsv[3] = {hue, 0.32, 0.88};
    vtkMath::HSVToRGB(hsv, rgb);
    table->SetTableValue(i, rgb[0], rgb[1], rgb[2]);
  }
  return table.Get();
}

vtkSmartPointer<vtkLookupTable> distances(double limit) {
  vtkNew<vtkLookupTable> table;
  table->SetHueRange(0.62, 0.0);
  table->SetSaturationRange(0.55, 0.75);
  table->SetValueRange(0.92, 0.95);
  table->SetTableRange(0, limit);
  table->Build();
  return table.Get();
}

Palette Palette::light() {
  return {{0.86, 0.89, 0.93}, {0.97, 0.98, 0.99}, {0.70, 0.775, 0.86}, {0.16, 0.20, 0.28},
          {0.90, 0.36, 0.06}, {0.06, 0.46, 0.82}, {0.14, 0.16, 0.20}};
}
Palette Palette::dark() {
  return {{0.10, 0.11, 0.13}, {0.20, 0.22, 0.26}, {0.56, 0.64, 0.74}, {0.86, 0.89, 0.94},
          {1.00, 0.58, 0.20}, {0.38, 0.74, 1.00}, {0.90, 0.92, 0.95}};
}

vtkSmartPointer<vtkLookupTable> role_colours(const Palette& palette) {
  const Rgb colours[] = {
      palette.body, {0.45, 0.48, 0.53}, {0.93, 0.62, 0.26}, {0.36, 0.66, 0.62}, palette.selected};
  vtkNew<vtkLookupTable> table;
  table->SetNumberOfTableValues(kSelectedRole + 1);
  table->SetTableRange(0, kSelectedRole);
  for (int i = 0; i <= kSelectedRole; ++i)
    table->SetTableValue(i, colours[i][0], colours[i][1], colours[i][2]);
  return table.Get();
}

vtkSmartPointer<vtkLookupTable> two_sided(double limit) {
  constexpr int steps = 255;
  const Rgb low{0.16, 0.36, 0.76}, middle{0.95, 0.95, 0.94}, high{0.80, 0.20, 0.16};
  vtkNew<vtkLookupTable> table;
  table->SetNumberOfTableValues(steps);
  table->SetTableRange(-limit, limit);
  for (int i = 0; i < steps; ++i) {
    const double t = 2.0 * i / (steps - 1) - 1;
    const Rgb& end = t < 0 ? low : high;
    Rgb c;
    for (size_t k = 0; k < 3; ++k) c[k] = middle[k] + std::abs(t) * (end[k] - middle[k]);
    table->SetTableValue(i, c[0], c[1], c[2]);
  }
  return table.Get();
}

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
