// SPDX-License-Identifier: MPL-2.0
// Captures VTK's messages and sets the C locale while VTK reads or writes.
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

/// While such an object exists, this thread uses decimal points, whatever the locale of the
/// process. VTK reads and writes numbers with streams that use the process's locale.
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

/// Suppresses VTK's messages while it exists, and stores the first error. Errors would otherwise
/// fill the terminal, and some are the only sign that part of a file was skipped. VTK has one
/// global message handler, so only one such object can exist at a time; other threads wait.
class VtkMessageCapture {
 public:
  VtkMessageCapture();
  ~VtkMessageCapture();
  VtkMessageCapture(const VtkMessageCapture&) = delete;
  VtkMessageCapture& operator=(const VtkMessageCapture&) = delete;
  /// The text of the first error; "" if there was none.
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
