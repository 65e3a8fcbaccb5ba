#include "batten/io/cad/cad_writer.h"

#include <BRepBndLib.hxx>
#include <BRepBuilderAPI_Transform.hxx>
#include <BRepTools.hxx>
#include <Bnd_Box.hxx>
#include <IGESCAFControl_Writer.hxx>
#include <IGESData_GlobalSection.hxx>
#include <IGESData_IGESModel.hxx>
#include <IGESData_IGESWriter.hxx>
#include <IGESSelect_WorkLibrary.hxx>
#include <STEPCAFControl_Writer.hxx>
#include <TCollection_HAsciiString.hxx>
#include <TopoDS_Iterator.hxx>
#include <algorithm>
#include <cmath>
#include <locale>
#include <sstream>

#include "batten/core/errors.h"
#include "batten/io/cad/occ_settings.h"
#include "batten/io/cad/step_text.h"

namespace batten {
namespace {

std::string step_of(const Handle(TDocStd_Document) & document, const CadWriteOptions& options,
                    OccSettings& occ) {
  occ.set("write.step.unit", cad_unit(options.unit_in_metres).c_str());
  occ.set("write.step.schema", options.ap242 ? "AP242DIS" : "AP214IS");
  occ.set("write.stepcaf.subshapes.name", 1);
  occ.set("write.surfacecurve.mode", 1);
  STEPCAFControl_Writer writer;
  if (!writer.Transfer(document, STEPControl_AsIs))
    throw Error("OpenCASCADE cannot turn the shapes into STEP");
  std::ostringstream out;
  put_step(writer.ChangeWriter(), {options.name, "", "shapes"}, out);
  return out.str();
}

std::string iges_of(const Handle(TDocStd_Document) & document, const TopoDS_Shape& shape,
                    const CadWriteOptions& options, OccSettings& occ) {
  occ.set("write.iges.unit", cad_unit(options.unit_in_metres).c_str());
  occ.set("write.iges.brep.mode", 1);
  IGESCAFControl_Writer writer;
  if (!writer.Transfer(document)) throw Error("OpenCASCADE cannot turn the shapes into IGES");
  Bnd_Box box;
  BRepBndLib::Add(shape, box, false);
  double largest = 1;
  if (!box.IsVoid())
    for (const gp_Pnt& p : {box.CornerMin(), box.CornerMax()})
      largest = std::max({largest, std::abs(p.X()), std::abs(p.Y()), std::abs(p.Z())});
  const auto text_of = [](const std::string& s) { return new TCollection_HAsciiString(s.c_str()); };
  IGESData_GlobalSection header = writer.Model()->GlobalSection();
  header.SetMaxCoord(largest * 1e-3 / options.unit_in_metres);
  header.SetAuthorName(text_of(""));
  header.SetSendName(text_of(options.name));
  header.SetFileName(text_of(options.name));
  writer.Model()->SetGlobalSection(header);
  writer.ComputeModel();
  IGESData_IGESWriter text(writer.Model());
  text.FloatWriter().SetFormat("%#.17G");
  text.FloatWriter().SetZeroSuppress(false);
  text.SendModel(IGESSelect_WorkLibrary::DefineProtocol());
  std::ostringstream out;
  out.imbue(std::locale::classic());
  if (!text.Print(out)) throw Error("OpenCASCADE cannot write IGES");
  return out.str();
}

std::string brep_of(const TopoDS_Shape& shape, const CadWriteOptions& options) {
  TopoDS_Shape written = shape;
  if (TopoDS_Iterator it(shape); it.More()) {
    const TopoDS_Shape only = it.Value();
    it.Next();
    if (!it.More()) written = only;
  }
  const double factor = 1e-3 / options.unit_in_metres;
  if (std::abs(factor - 1) > 1e-12) {
    gp_Trsf scaling;
    scaling.SetScaleFactor(factor);
    written = BRepBuilderAPI_Transform(written, scaling, true).Shape();
  }
  std::ostringstream out;
  out.imbue(std::locale::classic());
  BRepTools::Write(written, out, false, false, TopTools_FormatVersion_VERSION_1);
  return out.str();
}

}  // namespace

std::string cad_text(const Handle(TDocStd_Document) & document, const TopoDS_Shape& shape,
                     const CadWriteOptions& options) {
  OccSettings occ;
  occ.set_unit("MM");
  return options.format == CadFormat::Step   ? step_of(document, options, occ)
         : options.format == CadFormat::Iges ? iges_of(document, shape, options, occ)
                                             : brep_of(shape, options);
}

}  // namespace batten
