// SPDX-License-Identifier: MPL-2.0
#include "batten/io/vtk/vtk_data.h"

#include <vtkErrorCode.h>
#include <vtkGenericDataObjectReader.h>
#include <vtkGenericDataObjectWriter.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLPolyDataReader.h>
#include <vtkXMLPolyDataWriter.h>
#include <vtkXMLUnstructuredGridReader.h>
#include <vtkXMLUnstructuredGridWriter.h>

#include <new>

#include "batten/core/errors.h"
#include "batten/io/files/input_file.h"
#include "batten/io/files/text.h"
#include "batten/io/vtk/vtk_message_capture.h"

namespace batten {
namespace fs = std::filesystem;

std::string legacy_vtk_text(vtkDataObject* data, bool binary, int version,
                            const std::string& title) {
  vtkNew<vtkGenericDataObjectWriter> writer;
  writer->SetInputDataObject(data);
  writer->WriteToOutputStringOn();
  binary ? writer->SetFileTypeToBinary() : writer->SetFileTypeToASCII();
  writer->SetFileVersion(version);
  if (!title.empty()) writer->SetHeader(title.c_str());
  writer->Write();
  return writer->GetOutputStdString();
}

namespace {

/// Reads the file, or the bytes that a child process made of it.
template <class Reader>
vtkSmartPointer<vtkPointSet> read_from(const fs::path& path, const std::string* bytes) {
  const auto fail = [&](const std::string& reason) -> void {
    throw InputError(path.string() + ": VTK cannot read this file: " + reason);
  };
  const VtkMessageCapture messages;
  vtkNew<Reader> reader;
  try {
    if (bytes) {
      reader->ReadFromInputStringOn();
      reader->SetInputString(*bytes);
    } else {
      if (!reader->CanReadFile(path.c_str())) fail("it is not a VTK XML file of this type");
      reader->SetFileName(path.c_str());
    }
    reader->Update();
  } catch (const InputError&) {
    throw;
  } catch (const std::bad_alloc&) {
    fail("there is not enough memory for the size it states");
  } catch (const std::exception& error) {
    fail(error.what());
  }
  if (!messages.first_error().empty()) fail(messages.first_error());
  if (reader->GetErrorCode() != vtkErrorCode::NoError)
    fail(vtkErrorCode::GetStringFromErrorCode(reader->GetErrorCode()));
  if (!reader->GetOutput() || !reader->GetOutput()->GetPoints()) fail("it has no points");
  auto result = vtkSmartPointer<vtkPointSet>::Take(reader->GetOutput()->NewInstance());
  result->ShallowCopy(reader->GetOutput());
  return result;
}

template <class Reader, class Writer>
vtkSmartPointer<vtkPointSet> read_with(const fs::path& path) {
  if (!is_sandboxed_read_enabled()) return read_from<Reader>(path, nullptr);
  const std::string bytes = sandboxed_read(path, "VTK", [&] {
    const auto data = read_from<Reader>(path, nullptr);
    vtkNew<Writer> writer;
    writer->SetInputDataObject(data);
    writer->WriteToOutputStringOn();
    writer->SetDataModeToAppended();
    writer->EncodeAppendedDataOff();
    writer->SetCompressorTypeToNone();
    writer->SetHeaderTypeToUInt64();
    writer->Write();
    std::string text = writer->GetOutputString();
    if (text.empty()) throw std::bad_alloc();  // the only reason, which VTK does not report
    return text;
  });
  return read_from<Reader>(path, &bytes);
}

/// Reads a legacy file (.vtk), or the bytes that a child process made of it.
vtkSmartPointer<vtkPointSet> legacy_from(const fs::path& path, const std::string* bytes) {
  const VtkMessageCapture messages;
  vtkNew<vtkGenericDataObjectReader> reader;
  if (bytes) {
    reader->ReadFromInputStringOn();
    reader->SetInputString(*bytes);
  } else {
    reader->SetFileName(path.c_str());
  }
  const auto fail = [&](const std::string& reason) -> void {
    throw InputError(path.string() + ": VTK cannot read this file: " + reason);
  };
  try {
    reader->Update();
  } catch (const std::bad_alloc&) {
    fail("there is not enough memory for the size it states");
  }
  if (!messages.first_error().empty()) fail(messages.first_error());
  auto* const data = vtkPointSet::SafeDownCast(reader->GetOutput());
  if (!data || !(vtkPolyData::SafeDownCast(data) || vtkUnstructuredGrid::SafeDownCast(data)))
    fail("found no POLYDATA and no UNSTRUCTURED_GRID, expected one of them");
  if (!data->GetPoints()) fail("it has no points");
  auto result = vtkSmartPointer<vtkPointSet>::Take(data->NewInstance());
  result->ShallowCopy(data);
  return result;
}

vtkSmartPointer<vtkPointSet> read_legacy(const fs::path& path) {
  if (!is_sandboxed_read_enabled()) return legacy_from(path, nullptr);
  const std::string bytes = sandboxed_read(path, "VTK", [&] {
    return legacy_vtk_text(legacy_from(path, nullptr), true,
                           vtkDataWriter::VTK_LEGACY_READER_VERSION_5_1, "");
  });
  return legacy_from(path, &bytes);
}

}  // namespace

vtkSmartPointer<vtkPointSet> read_vtk_data(const fs::path& path) {
  const std::string extension = lower_extension(path);
  if (extension == ".vtk") return read_legacy(path);
  if (extension == ".vtp") return read_with<vtkXMLPolyDataReader, vtkXMLPolyDataWriter>(path);
  return read_with<vtkXMLUnstructuredGridReader, vtkXMLUnstructuredGridWriter>(path);
}

}  // namespace batten
