#include "batten/io/pictures/colour_tables.h"

#include <vtkColorTransferFunction.h>
#include <vtkDataArray.h>
#include <vtkLookupTable.h>
#include <vtkNew.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "batten/core/eigen.h"

namespace batten::detail {

double rounded_up(double x) {
  const double power = std::pow(10, std::floor(std::log10(x)) - 1);
  return std::ceil(x / power * (1 - 1e-9)) * power;
}

double round_step(double x) {
  const double power = std::pow(10, std::floor(std::log10(x) + 1e-9)), digit = x / power;
  return power * (digit >= 5 ? 5 : digit >= 2 ? 2 : 1);
}

vtkSmartPointer<vtkLookupTable> diverging_colours(double limit) {
  vtkNew<vtkColorTransferFunction> colours;
  colours->SetColorSpaceToDiverging();
  colours->AddRGBPoint(-1, 0.230, 0.299, 0.754);
  colours->AddRGBPoint(0, 0.865, 0.865, 0.865);
  colours->AddRGBPoint(1, 0.706, 0.016, 0.150);
  auto table = vtkSmartPointer<vtkLookupTable>::New();
  constexpr int entries = 511;
  table->SetNumberOfTableValues(entries);
  for (int i = 0; i < entries; ++i) {
    double rgb[3];
    colours->GetColor(2.0 * i / (entries - 1) - 1, rgb);
    table->SetTableValue(i, rgb[0], rgb[1], rgb[2]);
  }
  table->SetRange(-limit, limit);
  return table;
}

namespace {

struct Stop {
  double at;
  Vec3 rgb;
};

// A table from 0 to the limit through these colours, blended as the eye sees them.
vtkSmartPointer<vtkLookupTable> table_of(const std::vector<Stop>& stops, double limit) {
  vtkNew<vtkColorTransferFunction> colours;
  colours->SetColorSpaceToLab();
  for (const Stop& s : stops) colours->AddRGBPoint(s.at, s.rgb.x(), s.rgb.y(), s.rgb.z());
  auto table = vtkSmartPointer<vtkLookupTable>::New();
  constexpr int entries = 256;
  table->SetNumberOfTableValues(entries);
  for (int i = 0; i < entries; ++i) {
    double rgb[3];
    colours->GetColor(static_cast<double>(i) / (entries - 1), rgb);
    table->SetTableValue(i, rgb[0], rgb[1], rgb[2]);
  }
  table->SetRange(0, limit);
  return table;
}

}  // namespace

vtkSmartPointer<vtkLookupTable> sequential_colours(double limit) {
  return table_of({{0, {0.90, 0.92, 0.94}},
                   {0.35, {0.55, 0.76, 0.86}},
                   {0.7, {0.16, 0.44, 0.70}},
                   {1, {0.06, 0.14, 0.42}}},
                  limit);
}

vtkSmartPointer<vtkLookupTable> heat_colours(double limit) {
  return table_of({{0, {0.19, 0.29, 0.66}},
                   {0.25, {0.33, 0.66, 0.80}},
                   {0.5, {0.66, 0.85, 0.55}},
                   {0.75, {0.98, 0.80, 0.38}},
                   {1, {0.76, 0.12, 0.13}}},
                  limit);
}

vtkSmartPointer<vtkLookupTable> striped_colours(double low, double high, double from,
                                                double width) {
  auto table = vtkSmartPointer<vtkLookupTable>::New();
  const int entries = static_cast<int>(std::clamp(128 * (high - low) / width, 256.0, 65536.0));
  table->SetNumberOfTableValues(entries);
  const Vec3 light(0.97, 0.97, 0.97), dark(0.10, 0.12, 0.16);
  constexpr double soft = 0.08;  // of a stripe: how wide the change is
  for (int i = 0; i < entries; ++i) {
    const double place = (low + (i + 0.5) / entries * (high - low) - from) / width;
    const double nearest = std::round(place),
                 after = std::clamp((place - nearest) / soft, -0.5, 0.5);
    const double share = 0.5 + (std::fmod(nearest, 2) == 0 ? after : -after);
    const Vec3 c = share * light + (1 - share) * dark;
    table->SetTableValue(i, c[0], c[1], c[2]);
  }
  table->SetRange(low, high);
  return table;
}

double field_limit(vtkDataArray& values) {
  std::vector<double> sorted;
  for (vtkIdType i = 0; i < values.GetNumberOfTuples(); ++i)
    if (const double v = values.GetTuple1(i); std::isfinite(v)) sorted.push_back(v);
  if (sorted.empty()) return 1;
  std::sort(sorted.begin(), sorted.end());
  const size_t cut = sorted.size() / 50;
  const double limit = std::max(std::abs(sorted[cut]), std::abs(sorted[sorted.size() - 1 - cut]));
  return limit > 1e-300 ? rounded_up(limit) : 1;
}

}  // namespace batten::detail
