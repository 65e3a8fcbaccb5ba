// SPDX-License-Identifier: MPL-2.0
// Hulls from sections alone, cut from surfaces of CAD files: distance of the loft from the original
// surface, compared with BRepOffsetAPI_ThruSections of the same sections. Needs those files, and
// reports if they are absent.
#include <cmath>
#include <cstdio>
#include <filesystem>

#include "batten/fairing/curves/curve_through_points.h"
#include "batten/skinning/model/model_shapes.h"
#include "batten/skinning/surfaces/section_region.h"
#include "batten/tests/support/test_data.h"
#include "bench.h"
#include "occ_loft.h"

namespace {

using namespace batten;
using namespace batten::bench;

struct DistanceStatistics {
  double max = 0, rms = 0;
};
DistanceStatistics distance_statistics(const IgesFace& face, const std::vector<Vec3>& points) {
  DistanceStatistics far;
  for (const Vec3& p : points) {
    const double d = face.distance(p);
    far.max = std::max(far.max, d);
    far.rms += d * d / static_cast<double>(points.size());
  }
  far.rms = std::sqrt(far.rms);
  return far;
}

std::vector<Vec3> points_of(const Surface& surface) {
  std::vector<Vec3> points;
  for (int t = 0; t < surface.mesh().triangle_count(); ++t)
    points.push_back(surface.position({t, Vec3::Constant(1.0 / 3)}));
  return points;
}

// A part of the length of a stored face.
struct Hull {
  const char* name;
  const char* file;
  int face;
  double from, to;  // fractions of its bounding box along x
};

void compare(const Hull& hull, const IgesFace& face, Table& table, Checks& checks) {
  for (const int count : {5, 7, 9}) {
    std::vector<std::vector<Vec3>> points;
    std::vector<CharacterLine> sections;
    std::vector<std::string> names;
    for (int k = 0; k < count; ++k) {
      const double f = hull.from + (hull.to - hull.from) * k / (count - 1);
      points.push_back(face.section((1 - f) * face.low().x() + f * face.high().x(), 61));
      if (points.back().empty()) {
        table.add({hull.name, std::to_string(count), "no section at " + text("%.2f", f)});
        return;
      }
      names.push_back("section " + std::to_string(k + 1));
      CharacterLine& line = sections.emplace_back();
      line.name = names.back();
      line.curve = curve_through_points(line.name, points.back(), 60);
    }
    const double size = (face.high() - face.low()).norm();
    SkinOptions options;
    options.tolerance = 1e-4 * size;
    std::string wrong;
    DistanceStatistics ours, residual;
    double t = 0;
    int triangles = 0, embedded = 0;
    try {
      const auto layout =
          std::make_shared<const ModelLayout>(section_region(hull.name, sections, options));
      LoftedModel loft;
      t = cpu_seconds_of([&] { loft = loft_model(layout, names, 0.5 * options.tolerance); });
      const ModelLayout& model = *loft.layout;
      ours = distance_statistics(face, points_of(model.surface(loft.dofs)));
      residual.max = model.line_constraints().max_residual(loft.dofs) / size;
      triangles = model.mesh()->triangle_count();
      embedded = isize(model.region(0).embedded());
    } catch (const std::exception& e) {
      wrong = e.what();
    }
    const DistanceStatistics occ = distance_statistics(face, loft_points(points, 40));
    const auto fraction = [&](double d) { return text("%.2e", d / size); };
    table.add({hull.name, std::to_string(count), std::to_string(triangles),
               std::to_string(embedded), wrong.empty() ? fraction(ours.max) : wrong.substr(0, 60),
               fraction(ours.rms), fraction(occ.max), fraction(occ.rms), text("%.1e", residual.max),
               text("%.3f", t)});
    const std::string which = std::string(hull.name) + " from " + std::to_string(count);
    // Differences below the tolerance of the curves do not count.
    const auto over = [&](double our, double their) {
      return wrong.empty() ? our / std::max(their, options.tolerance) : 1e9;
    };
    const std::string to = " over ThruSections', or over the tolerance of the curves";
    checks.at_most(which + " sections: largest distance" + to, over(ours.max, occ.max), 1);
    checks.at_most(which + " sections: rms distance" + to, over(ours.rms, occ.rms), 1);
  }
}

}  // namespace

int main(int argc, char** argv) {
  Checks checks;
  const std::vector<Hull> hulls = {
      {"wigley", "lines-ship-iges/wigley.iges", 0, 0.1, 0.9},
      {"series 60", "lines-ship-iges/series_60.iges", 0, 0.1, 0.9},
      {"bulbous bow", "lines-dealii-iges/DTMB-5415_bulbous_bow.iges", 0, 0.45, 0.85},
      {"KVLCC2", "lines-ship-iges/kvlcc2m.iges", 0, 0.1, 0.9}};
  Table table;
  table.add({"hull", "sections", "triangles", "embedded", "loft: max/size", "rms",
             "ThruSections: max", "rms", "curves", "s"});
  bool any = false;
  for (const Hull& hull : hulls) {
    const auto file = batten_test::optional_data(hull.file);
    if (file.empty()) continue;
    const std::vector<IgesFace> faces = IgesFace::read(file);
    if (argc > 1 && std::string(argv[1]) == "list")
      for (size_t f = 0; f < faces.size(); ++f)
        std::printf("%s face %zu: (%g, %g, %g) to (%g, %g, %g)\n", hull.name, f, faces[f].low().x(),
                    faces[f].low().y(), faces[f].low().z(), faces[f].high().x(),
                    faces[f].high().y(), faces[f].high().z());
    if (faces.size() <= static_cast<size_t>(hull.face)) continue;
    any = true;
    compare(hull, faces[static_cast<size_t>(hull.face)], table, checks);
  }
  if (!any) std::printf("Skipped: no file of a hull, or no OpenCASCADE.\n");
  table.print();
  checks.print("sections");
}
