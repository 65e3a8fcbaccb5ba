#include "batten/io/cad/iges_text.h"

#include <IGESData_IGESModel.hxx>
#include <IGESData_IGESWriter.hxx>
#include <IGESSelect_WorkLibrary.hxx>
#include <Interface_FloatWriter.hxx>

namespace batten {

bool print_iges(IGESControl_Writer& writer, std::ostream& out) {
  writer.ComputeModel();
  IGESData_IGESWriter text(writer.Model());
  text.FloatWriter().SetFormat("%#.17G");
  text.FloatWriter().SetZeroSuppress(false);
  text.SendModel(IGESSelect_WorkLibrary::DefineProtocol());
  return text.Print(out);
}

}  // namespace batten
