// SPDX-License-Identifier: MPL-2.0
// Interactive sculpting: a hundred updates of a drag, undo and redo, and the result as a scene.
#include <batten/batten.h>

#include <cstdio>

int main(int, char**) {
  const batten::Model sheet =
      batten::skin({{"rim", {{0, 0, 0}, {400, 0, 0}, {400, 300, 0}, {0, 300, 0}, {0, 0, 0}}}});
  batten::Session session(sheet);
  session.add_pressure("swell", {.min = 0, .max = 100});
  for (int i = 1; i <= 100; ++i) {
    session.set("swell", 0.2 * i);
    session.update();
    session.frame();  // points and normals to draw; triangles: pattern->facets
  }
  session.solve();
  const double swollen = session.volume();
  session.undo();
  const double flat = session.volume();
  session.redo();
  std::printf("volume %.0f mm³, after undo %.3g mm³\n", session.volume(), flat);
  session.model().save("swollen.toml");  // a scene with the pressure, which every program opens
  return session.volume() == swollen ? 0 : 1;
}
