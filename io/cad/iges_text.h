// The text of IGES files. Internal.
#pragma once

#include <IGESControl_Writer.hxx>
#include <ostream>

namespace batten {

/// Completes the model of a writer and prints it with digits that come back as the same numbers. Returns false
/// where OpenCASCADE cannot.
bool print_iges(IGESControl_Writer& writer, std::ostream& out);

}  // namespace batten
