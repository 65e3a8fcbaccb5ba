#include "batten/io/cad/patch_file.h"

#include <vtkSmartPointer.h>
#include <vtkXMLDataElement.h>
#include <vtkXMLUtilities.h>
#include <BRepBndLib.hxx>
#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepBuilderAPI_Sewing.hxx>
#include <BRep_Builder.hxx>
#include <Bnd_Box.hxx>
#include <Geom_BSplineSurface.hxx>
#include <TColStd_Array1OfInteger.hxx>
#include <TColStd_Array1OfReal.hxx>
#include <TColStd_Array2OfReal.hxx>
#include <TColgp_Array2OfPnt.hxx>
#include <TopoDS_Compound.hxx>

#include <charconv>
#include <cmath>
#include <cstring>
#include <vector>

#include "batten/core/errors.h"
#include "batten/core/isize.h"
#include "batten/io/cad/continuity_report.h"
#include "batten/io/files/nesting.h"
#include "batten/io/files/text.h"
#include "batten/io/vtk/vtk_message_capture.h"

namespace batten {
namespace {

/// One direction: distinct knots with how often each comes.
struct Knots {
  int degree = 0;
  std::vector<double> at;
  std::vector<int> times;
  int poles() const {
    int sum = -degree - 1;
    for (const int t : times) sum += t;
    return sum;
  }
};

class PatchReader {
 public:
  explicit PatchReader(std::string where) : where_(std::move(where)) {}

  TopoDS_Face face(vtkXMLDataElement& geometry) const {
    vtkXMLDataElement* basis = geometry.FindNestedElementWithName("Basis");
    if (!basis) fail("no Basis", "one with two B-spline bases");
    std::vector<double> weights;
    if (vtkXMLDataElement* inner = basis->FindNestedElementWithName("Basis");
        inner && !inner->GetAttribute("index")) {  // of a rational patch, beside its weights
      if (vtkXMLDataElement* w = basis->FindNestedElementWithName("weights")) weights = numbers(*w);
      basis = inner;
    }
    const Knots u = knots(*basis, "0"), v = knots(*basis, "1");
    vtkXMLDataElement* coefs = geometry.FindNestedElementWithName("coefs");
    if (!coefs || !coefs->GetAttribute("geoDim") || std::strcmp(coefs->GetAttribute("geoDim"), "3"))
      fail("no coefs of three coordinates", "coefs geoDim=\"3\"");
    const std::vector<double> x = numbers(*coefs);
    const long count = static_cast<long>(u.poles()) * v.poles();
    if (isize(x) != 3 * count)
      fail(std::to_string(x.size()) + " coordinates", "3 for each of " + std::to_string(u.poles()) +
                                                          " × " + std::to_string(v.poles()) +
                                                          " poles");
    if (!weights.empty() && isize(weights) != count)
      fail(std::to_string(weights.size()) + " weights", "one for each pole");
    return made(u, v, x, weights);
  }

 private:
  [[noreturn]] void fail(const std::string& found, const std::string& expected) const {
    throw InputError(where_ + "found " + found + ", expected " + expected);
  }

  std::vector<double> numbers(vtkXMLDataElement& element) const {
    const char* text = element.GetCharacterData();
    std::string_view rest = text ? text : "";
    constexpr std::string_view blanks = " \t\r\n\f\v";
    std::vector<double> values;
    for (;;) {
      rest.remove_prefix(std::min(rest.find_first_not_of(blanks), rest.size()));
      if (rest.empty()) break;
      const std::string_view word = rest.substr(0, rest.find_first_of(blanks));
      double value = 0;
      const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
      if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(value))
        fail("'" + std::string(word.substr(0, 40)) + "'", "a finite number");
      values.push_back(value);
      rest.remove_prefix(word.size());
    }
    return values;
  }

  Knots knots(vtkXMLDataElement& bases, const char* index) const {
    for (int k = 0; k < bases.GetNumberOfNestedElements(); ++k) {
      vtkXMLDataElement* basis = bases.GetNestedElement(k);
      const char* own = basis->GetAttribute("index");
      if (!own || std::strcmp(own, index) != 0) continue;
      vtkXMLDataElement* vector = basis->FindNestedElementWithName("KnotVector");
      Knots knots;
      if (!vector || !vector->GetScalarAttribute("degree", knots.degree) || knots.degree < 1 ||
          knots.degree > Geom_BSplineSurface::MaxDegree())
        fail("no KnotVector of a degree from 1 to 25 in basis " + std::string(index), "one");
      for (const double value : numbers(*vector)) {
        if (!knots.at.empty() && value < knots.at.back()) fail("knots that fall", "rising ones");
        if (knots.at.empty() || value > knots.at.back()) {
          knots.at.push_back(value);
          knots.times.push_back(0);
        }
        ++knots.times.back();
      }
      check(knots);
      return knots;
    }
    fail("no basis " + std::string(index), "two B-spline bases");
  }

  void check(const Knots& knots) const {
    const int ends = knots.degree + 1;
    bool sound = knots.at.size() >= 2 && knots.times.front() == ends && knots.times.back() == ends;
    for (size_t k = 1; k + 1 < knots.times.size(); ++k)
      sound = sound && knots.times[k] <= knots.degree;
    if (!sound)
      fail("knots that do not clamp their ends",
           std::to_string(ends) + " equal ones at either end, fewer between");
  }

  TopoDS_Face made(const Knots& u, const Knots& v, const std::vector<double>& x,
                   const std::vector<double>& weights) const {
    TColgp_Array2OfPnt poles(1, u.poles(), 1, v.poles());
    TColStd_Array2OfReal w(1, u.poles(), 1, v.poles());
    for (int j = 0; j < v.poles(); ++j)
      for (int i = 0; i < u.poles(); ++i) {
        const size_t k = static_cast<size_t>(j) * u.poles() + i;
        poles(i + 1, j + 1) = gp_Pnt(x[3 * k], x[3 * k + 1], x[3 * k + 2]);
        w(i + 1, j + 1) = weights.empty() ? 1 : weights[k];
        if (!(w(i + 1, j + 1) > 0)) fail("weight " + format_number(weights[k]), "one above 0");
      }
    const Handle(Geom_BSplineSurface) surface = new Geom_BSplineSurface(
        poles, w, array<TColStd_Array1OfReal>(u.at), array<TColStd_Array1OfReal>(v.at),
        array<TColStd_Array1OfInteger>(u.times), array<TColStd_Array1OfInteger>(v.times), u.degree,
        v.degree);
    constexpr double point = 1e-7;  // a side that is shorter is a point
    BRepBuilderAPI_MakeFace maker(surface, point);
    if (!maker.IsDone()) fail("a surface that has no face", "a sound patch");
    return maker.Face();
  }

  template <class Array, class Values>
  static Array array(const Values& values) {
    Array result(1, isize(values));
    for (int i = 0; i < isize(values); ++i) result(i + 1) = values[i];
    return result;
  }

  std::string where_;
};

}  // namespace

TopoDS_Shape read_patches(const std::filesystem::path& file, const std::string& text) {
  check_xml_nesting_depth(text, file.string());
  const auto root = [&] {
    const VtkMessageCapture messages;
    return vtkSmartPointer<vtkXMLDataElement>::Take(
        vtkXMLUtilities::ReadElementFromString(text.c_str()));
  }();
  if (!root) throw InputError(file.string() + ": found no sound XML, expected patches of G+Smo");
  TopoDS_Compound all;
  BRep_Builder builder;
  builder.MakeCompound(all);
  int count = 0;
  for (int k = 0; k < root->GetNumberOfNestedElements(); ++k) {
    vtkXMLDataElement* geometry = root->GetNestedElement(k);
    const char* type = geometry->GetAttribute("type");
    if (std::strcmp(geometry->GetName(), "Geometry") != 0 || !type ||
        (std::strcmp(type, "TensorBSpline2") != 0 && std::strcmp(type, "TensorNurbs2") != 0))
      continue;
    ++count;
    const PatchReader reader(file.string() + ": patch " + std::to_string(count) + ": ");
    builder.Add(all, reader.face(*geometry));
  }
  if (count == 0)
    throw InputError(file.string() +
                     ": found no Geometry of type TensorBSpline2 or TensorNurbs2, "
                     "expected patches of G+Smo");
  Bnd_Box box;
  BRepBndLib::AddOptimal(all, box, false, false);
  BRepBuilderAPI_Sewing sewing(ContinuityOptions{}.sewing * std::sqrt(box.SquareExtent()));
  sewing.Add(all);
  sewing.Perform();
  return sewing.SewedShape();
}

}  // namespace batten
