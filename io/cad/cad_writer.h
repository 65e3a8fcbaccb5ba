// Writes CAD documents as text. Internal.
#pragma once

#include <string>

#include "batten/io/cad/cad_file.h"

namespace batten {

struct CadWriteOptions {
  CadFormat format = CadFormat::Step;
  bool ap242 = false;            ///< of STEP, instead of AP214
  double unit_in_metres = 1e-3;  ///< of the file
  std::string name;              ///< of the file, in its header
};

/// The text of a file with all products of a document and their attributes, of BREP the shape.
/// Throws InputError for a unit that such files cannot have, Error when OpenCASCADE fails.
std::string cad_text(const Handle(TDocStd_Document) & document, const TopoDS_Shape& shape,
                     const CadWriteOptions& options);

}  // namespace batten
