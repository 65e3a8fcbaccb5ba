#include "batten/io/pictures/display.h"

#include <dlfcn.h>

#include <cstdlib>
#include <string>

#include "batten/core/errors.h"

namespace batten {

void require_display() {
  static std::string good;  // the server that was asked last
  const std::string advice = "; run under xvfb-run -a, or where an X server is";
  const char* set = std::getenv("DISPLAY");
  const std::string name = set ? set : "";
  if (name.empty()) throw InputError("no display: VTK draws only with an X server" + advice);
  if (name == good) return;
  void* library = dlopen("libX11.so.6", RTLD_NOW | RTLD_LOCAL);
  if (!library) throw InputError("no display: libX11.so.6 is missing" + advice);
  const auto open = reinterpret_cast<void* (*)(const char*)>(dlsym(library, "XOpenDisplay"));
  const auto query = reinterpret_cast<int (*)(void*, const char*, int*, int*, int*)>(
      dlsym(library, "XQueryExtension"));
  // The connection stays: servers start anew, and refuse others meanwhile, when the last one ends.
  static void* display = nullptr;
  display = open && query ? open(nullptr) : nullptr;
  if (!display)
    throw InputError("no display: the X server '" + name + "' does not answer" + advice);
  int opcode, event, error;
  if (!query(display, "GLX", &opcode, &event, &error))
    throw InputError("no display: the X server '" + name + "' has no OpenGL (GLX)" + advice);
  good = name;
}

}  // namespace batten
