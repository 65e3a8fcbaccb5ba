// SPDX-License-Identifier: MPL-2.0
// Mesh morphing: bends a plate while its holes stay rigid, and checks the radii of the holes.
//
// Usage: holes MESH FILE, such as examples/10-plate-with-holes/plate.obj
#include <batten/batten.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

int main(int argc, char** argv) {
  const batten::Mesh mesh = batten::read_mesh(argc > 1 ? argv[1] : "plate.obj");
  const batten::Vec3 low = mesh.bounds().min(), high = mesh.bounds().max();
  const double length = high.x() - low.x(), end = 0.03 * length;
  batten::DeformerSettings settings;
  settings.fixed = mesh.vertices_in(low, {low.x() + end, high.y(), high.z()});
  settings.handles = {{"end", mesh.vertices_in({high.x() - end, low.y(), low.z()}, high)}};
  for (const batten::Hole& hole : mesh.holes())
    settings.features.push_back({hole.name, hole.vertices});
  batten::Deformer deformer(mesh, settings);
  const batten::Points bent = deformer.deform(
      {{"end",
        {.translate = {-0.17 * length, 0, 0.48 * length}, .axis = {0, -1, 0}, .angle = 60}}});
  mesh.save("bent.obj", bent);

  double change = 0, rise = 0;  // largest change of a radius, relative; largest rise of a centre
  for (const batten::Hole& hole : mesh.holes()) {
    const batten::HoleMeasure after = batten::measure_hole(bent, hole.loop);
    change = std::max(change, std::abs(after.radius / hole.radius - 1));
    rise = std::max(rise, after.centre.z() - hole.centre.z());
  }
  std::printf("%zu holes, raised by up to %.3g; largest change of a radius: %.2g\n",
              settings.features.size(), rise, change);
  return change <= 1e-12 && deformer.residual() <= 1e-12 && rise > 0.1 * length ? 0 : 1;
}
