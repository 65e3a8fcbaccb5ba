// What VTK says while it reads or writes. Internal.
#pragma once

#include <vtkLogger.h>
#include <vtkNew.h>
#include <vtkOutputWindow.h>
#include <vtkSmartPointer.h>

#include <mutex>
#include <string>

namespace batten {

/// Takes VTK's messages as long as it exists, and keeps the first error. Otherwise errors would
/// fill the terminal, and some are the only sign that a part of a file was passed over. VTK has one
/// place for all messages, so there is one such object at a time (others wait).
class VtkMessages {
 public:
  VtkMessages();
  ~VtkMessages();
  VtkMessages(const VtkMessages&) = delete;
  VtkMessages& operator=(const VtkMessages&) = delete;
  /// Its sentence, or "" while there was none.
  const std::string& first_error() const;

 private:
  class Listener;
  std::lock_guard<std::mutex> lock_;
  vtkSmartPointer<vtkOutputWindow> before_;
  vtkLogger::Verbosity verbosity_;
  vtkNew<Listener> listener_;
};

}  // namespace batten
