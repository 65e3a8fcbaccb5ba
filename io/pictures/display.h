// SPDX-License-Identifier: MPL-2.0
// The X server on which VTK draws pictures: that of the user, or a virtual one.
#pragma once

namespace batten {

/// Connects to an X server with OpenGL, for all pictures of this process. VTK would abort the
/// process without one.
///
/// Takes the X server of the variable DISPLAY if it answers. Otherwise starts a virtual one, Xvfb,
/// which ends with this process, however that ends; the environment does not change. The program
/// Xvfb is searched for in this order:
///
///     $BATTEN_XVFB                      this program only; set, but empty: start none
///     ../LIB/batten/xvfb/bin/Xvfb       relative to the folder of the program, LIB is
///                                       CMAKE_INSTALL_LIBDIR: for archives that run on any system
///     Xvfb                              on the PATH
///
/// The second one may be a script that sets what a relocated server needs (library path, -xkbdir,
/// the folder of xkbcomp) and ends with: exec SERVER "$@". Descriptors 3 and 4 belong to the server.
/// If the folder ../LIB/batten/xvfb/lib/dri exists, it is where this process looks for the drivers
/// of Mesa, unless LIBGL_DRIVERS_PATH is set.
///
/// Call it on the main thread, before a long computation that ends with drawing pictures. Throws
/// InputError if there is no X server. Cost: at the first call 0.1 to 0.5 s if a server is started.
void require_display();

/// Connects to the X server of the variable DISPLAY only, for a window. Throws InputError if it does
/// not answer, or has no OpenGL.
void require_visible_display();

namespace detail {
/// The connection of require_display(), a Display of libX11, which stays open until the process ends.
void* x_display();
}  // namespace detail

}  // namespace batten
