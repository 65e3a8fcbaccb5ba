// The colours of the view.
#pragma once

#include <vtkSmartPointer.h>
#include <array>
#include <vtkNew.h>
#include <string>

class vtkLookupTable;

namespace batten::studio {

using Rgb = std::array<double, 3>;

/// Colours of everything, light or dark.
struct Palette {
  Rgb low, high, body, line, selected, draft, text;
  static Palette light();
  static Palette dark();
};

/// A table from `low` to `high` of `count` stripes in two colours.
vtkSmartPointer<vtkLookupTable> stripes(double low, double high, int count, const Rgb& a,
                                        const Rgb& b);
/// Colours that neighbours tell apart: hues by the golden angle.
vtkSmartPointer<vtkLookupTable> region_colours(int count);
/// The colours of facets by MeshView::Role, and behind them of what is chosen.
inline constexpr int kSelectedRole = 4;
vtkSmartPointer<vtkLookupTable> role_colours(const Palette& palette);
/// A table from -limit to the limit: from blue over white to red.
vtkSmartPointer<vtkLookupTable> two_sided(double limit);
/// A table from 0 to the limit: from blue to red.
vtkSmartPointer<vtkLookupTable> distances(double limit);

}  // namespace batten::studio

// Words and a scale of colours over the view.

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
