// SPDX-License-Identifier: MPL-2.0
// Colours, lookup tables and legend of the 3-D view.
#pragma once

#include <vtkNew.h>
#include <vtkSmartPointer.h>
#include <array>
#include <string>

class vtkLookupTable;

namespace batten::studio {

using Rgb = std::array<double, 3>;

/// Colours of the view, in a light and a dark theme.
struct Palette {
  Rgb low, high, body, line, selected, draft, text;
  static Palette light();
  static Palette dark();
};

/// Lookup table with `count` stripes from `low` to `high`, alternating between two colours.
vtkSmartPointer<vtkLookupTable> stripes(double low, double high, int count, const Rgb& a,
                                        const Rgb& b);
/// Categorical colours that are easy to tell apart (hues at golden-angle steps).
vtkSmartPointer<vtkLookupTable> region_colours(int count);
/// Lookup table for facets by MeshView::Role; the entry kSelectedRole is for selected facets.
inline constexpr int kSelectedRole = 4;
vtkSmartPointer<vtkLookupTable> role_colours(const Palette& palette);
/// Diverging colours from -limit (blue) over white to limit (red).
vtkSmartPointer<vtkLookupTable> two_sided(double limit);
/// Sequential colours from 0 (blue) to the limit (red).
vtkSmartPointer<vtkLookupTable> distances(double limit);

}  // namespace batten::studio

// Legend: text and colour scale over the view.

class vtkRenderer;
class vtkScalarBarActor;
class vtkTextActor;

namespace batten::studio {

/// Draws a text and a colour scale over the view.
class Legend {
 public:
  explicit Legend(vtkRenderer* renderer);
  ~Legend();
  void set_palette(const Palette& palette);
  void set_text(const std::string& overlay_text);
  /// Shows the scale of a lookup table, with a title; null: no scale.
  void set_scale(vtkLookupTable* table, const std::string& title);

 private:
  vtkNew<vtkTextActor> text_, title_;
  vtkNew<vtkScalarBarActor> scale_;
};

}  // namespace batten::studio
