// SPDX-License-Identifier: MPL-2.0
// Writes points as a table of curves and reads them again.
#include <batten/io/lines/curve_files.h>
#include <batten/io/lines/drawing.h>

#include <cstdio>
#include <fstream>

int main() {
  std::ofstream("consumer.csv") << "x,y,z\n0,0,0\n1,0,0\n2,1,0\n";
  const auto curves = batten::read_point_lines("consumer.csv");
  std::printf("%zu curves\n", curves.size());
  return curves.size() == 1 ? 0 : 1;
}
