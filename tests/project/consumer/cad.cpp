// SPDX-License-Identifier: MPL-2.0
// Writes a curve to STEP and reads it again, by OpenCASCADE.
#include <batten/io/lines/cad_lines.h>

#include <cmath>
#include <cstdio>

int main() {
  using namespace batten;
  Points ends(2, 3), slopes(2, 3);
  ends << 0, 0, 0, 3, 4, 0;
  slopes << 3, 4, 0, 3, 4, 0;
  write_cad_curves("consumer.step", {{"line", HermiteCurve({0, 1}, ends, slopes), {0, 1}, {}}}, {});
  const auto read = read_cad_lines("consumer.step", 0.001);
  const double length = (read[0].curve->evaluate(read[0].curve->end()) -
                         read[0].curve->evaluate(read[0].curve->start()))
                            .norm();
  std::printf("%zu curve of length %.12f\n", read.size(), length);
  return read.size() == 1 && std::abs(length - 5) < 1e-9 ? 0 : 1;
}
