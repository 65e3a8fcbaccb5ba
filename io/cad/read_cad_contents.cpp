#include "batten/io/cad/read_cad_contents.h"

#include <Standard_Failure.hxx>

#include "batten/core/errors.h"
#include "batten/io/cad/cad_contents_bytes.h"
#include "batten/io/cad/measure_contents.h"
#include "batten/io/cad/occ_settings.h"
#include "batten/io/files/sandboxed_read.h"

namespace batten {

CadContents read_cad_contents(const std::filesystem::path& file) {
  return contents_from_bytes(sandboxed_read(file, "OpenCASCADE", [&] {
    const CadFile cad = read_cad_here(file);
    const OccSettings occ;
    try {
      return to_bytes(contents_of(cad));
    } catch (const Standard_Failure& failure) {
      throw InputError(file.string() +
                       ": OpenCASCADE cannot measure it: " + failure.GetMessageString());
    }
  }));
}

}  // namespace batten
