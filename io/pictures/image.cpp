#include "batten/io/pictures/image.h"

#include <vtkErrorCode.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPNGWriter.h>

#include <algorithm>
#include <string>

#include "batten/core/errors.h"
#include "batten/io/files/atomic_file.h"

namespace batten {

void write_png(const std::filesystem::path& path, const Image& image) {
  const size_t row = size_t{3} * static_cast<size_t>(std::max(image.width, 0));
  if (image.width < 1 || image.height < 1 || image.rgb.size() != row * image.height)
    throw InputError(path.string() + ": found a picture of " + std::to_string(image.width) + " x " +
                     std::to_string(image.height) + " pixels with " +
                     std::to_string(image.rgb.size()) + " bytes, expected three a pixel");
  AtomicFile file(path);
  vtkNew<vtkImageData> data;
  data->SetDimensions(image.width, image.height, 1);
  data->AllocateScalars(VTK_UNSIGNED_CHAR, 3);
  auto* out = static_cast<unsigned char*>(data->GetScalarPointer());
  for (int y = image.height - 1; y >= 0; --y, out += row)
    std::copy_n(&image.rgb[static_cast<size_t>(y) * row], row, out);
  vtkNew<vtkPNGWriter> writer;
  writer->SetFileName(file.temporary().c_str());
  writer->SetInputData(data);
  writer->Write();
  if (writer->GetErrorCode() != vtkErrorCode::NoError)
    throw FileError(path.string() + ": cannot write this file: " +
                    vtkErrorCode::GetStringFromErrorCode(writer->GetErrorCode()));
  file.commit();
}

}  // namespace batten
