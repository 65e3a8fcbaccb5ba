// SPDX-License-Identifier: MPL-2.0
#include "batten/io/vtk/vtk_message_capture.h"

#include <string_view>

#include "batten/io/files/text.h"

namespace batten {
namespace {

std::mutex& capture_mutex() {
  static std::mutex one;
  return one;
}

}  // namespace

// Streams use the global C++ locale. It is changed only if its numbers do not use plain decimal
// points. The new locale has no name, so that setting it does not change the C library's locale.
ClassicLocaleScope::ClassicLocaleScope() : own_(newlocale(LC_ALL_MASK, "C", nullptr)) {
  before_in_c_ = uselocale(own_);
  const auto& numbers = std::use_facet<std::numpunct<char>>(before_);
  if (numbers.decimal_point() != '.' || !numbers.grouping().empty())
    std::locale::global(std::locale(before_, new std::numpunct<char>));
}

ClassicLocaleScope::~ClassicLocaleScope() {
  if (!(std::locale() == before_)) std::locale::global(before_);
  uselocale(before_in_c_);
  freelocale(own_);
}

class VtkMessageCapture::Listener : public vtkOutputWindow {
 public:
  static Listener* New() { return new Listener; }
  void DisplayText(const char*) override {}
  void DisplayErrorText(const char* text) override {
    if (!first.empty()) return;
    // VTK's format: "ERROR: In file, line n\nclass (address): message"
    std::string_view message = text ? text : "";
    if (const size_t at = message.find("): "); at != message.npos) message = message.substr(at + 3);
    first = trimmed(message.substr(0, message.find('\n')));
    if (first.empty()) first = "it is damaged";
  }
  void DisplayWarningText(const char*) override {}
  void DisplayGenericWarningText(const char*) override {}
  void DisplayDebugText(const char*) override {}

  std::string first;
};

VtkMessageCapture::VtkMessageCapture()
    : lock_(capture_mutex()),
      before_(vtkOutputWindow::GetInstance()),
      verbosity_(vtkLogger::GetCurrentVerbosityCutoff()) {
  vtkOutputWindow::SetInstance(listener_);
  vtkLogger::SetStderrVerbosity(vtkLogger::VERBOSITY_OFF);
}

VtkMessageCapture::~VtkMessageCapture() {
  vtkLogger::SetStderrVerbosity(verbosity_);
  vtkOutputWindow::SetInstance(before_);
}

const std::string& VtkMessageCapture::first_error() const { return listener_->first; }

}  // namespace batten
