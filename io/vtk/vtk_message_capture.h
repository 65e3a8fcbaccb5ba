// What VTK says while it reads or writes. Internal.
#pragma once

#include <vtkLogger.h>
#include <vtkNew.h>
#include <vtkOutputWindow.h>
#include <vtkSmartPointer.h>

#include <clocale>
#include <locale>
#include <mutex>
#include <string>

namespace batten {

/// Numbers have points in this thread, whatever locale the process has, as long as such an object
/// exists: VTK writes and reads numbers by streams that know the process's locale only.
class ClassicLocaleScope {
 public:
  ClassicLocaleScope();
  ~ClassicLocaleScope();
  ClassicLocaleScope(const ClassicLocaleScope&) = delete;
  ClassicLocaleScope& operator=(const ClassicLocaleScope&) = delete;

 private:
  std::locale before_;
  locale_t own_, before_in_c_;
};

/// Takes VTK's messages as long as it exists, and keeps the first error. Otherwise errors would
/// fill the terminal, and some are the only sign that a part of a file was passed over. VTK has one
/// place for all messages, so there is one such object at a time (others wait).
class VtkMessageCapture {
 public:
  VtkMessageCapture();
  ~VtkMessageCapture();
  VtkMessageCapture(const VtkMessageCapture&) = delete;
  VtkMessageCapture& operator=(const VtkMessageCapture&) = delete;
  /// Its sentence, or "" while there was none.
  const std::string& first_error() const;

 private:
  class Listener;
  std::lock_guard<std::mutex> lock_;
  ClassicLocaleScope numbers_;
  vtkSmartPointer<vtkOutputWindow> before_;
  vtkLogger::Verbosity verbosity_;
  vtkNew<Listener> listener_;
};

}  // namespace batten
