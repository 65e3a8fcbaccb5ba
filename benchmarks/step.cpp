// SPDX-License-Identifier: MPL-2.0
// STEP files: one face per face of the model, and three exact ones per triangle, of the examples
// and of sketches, measured by an independent reader; compared with a faceted file of the same
// shape at the same tolerance, OpenCASCADE's filling, and the conversions of Gmsh and OpenCASCADE.
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>

#include "batten/benchmarks/step_cross_check.h"
#include "batten/core/errors.h"
#include "batten/fem/surface_projector.h"
#include "batten/io/files/text.h"
#include "batten/io/scene/scene.h"
#include "batten/io/step/step.h"
#include "batten/scenes/commands.h"
#include "batten/scenes/lines/scene_lines.h"
#include "batten/scenes/shapes/solved_shape.h"
#include "batten/tests/support/test_data.h"
#include "bench.h"
#include "occ_filling.h"
#include "occ_step_file.h"

namespace {

using namespace batten;
using namespace batten::bench;
namespace fs = std::filesystem;

struct Model {
  std::string name;
  Scene scene;
  std::optional<BuiltModel> made;
  SolvedShape shape;
  double size = 0, unit = 1e-3;
  std::vector<const SkinnedRegion*> regions() const { return shape.all(); }
};

std::unique_ptr<Model> model_of(const std::string& name, Scene scene) {
  auto model = std::make_unique<Model>();
  model->name = name;
  model->scene = std::move(scene);
  model->made = build_model(model->scene, faired_lines(model->scene, {}).lines);
  model->shape = solve_refined_shape(*model->made, model->scene);
  model->unit = unit_in_metres(model->scene.unit);
  Box3 box;
  for (const SkinnedRegion* region : model->regions())
    for (const auto& loop : region->boundary)
      for (const BoundarySegment& piece : loop) {
        const HermiteCurve curve = boundary_curve(*region, piece);
        for (int i = 0; i < curve.node_count(); ++i) box.extend(curve.position(i));
      }
  model->size = box.diagonal().norm();
  return model;
}

std::vector<std::unique_ptr<Model>> all_models() {
  std::vector<std::unique_ptr<Model>> models;
  const std::string examples = std::string(BATTEN_SOURCE_DIR) + "/examples/";
  for (const auto& [name, folder] : std::vector<std::pair<std::string, std::string>>{
           {"door", "05-door"}, {"goblet", "08-goblet"}, {"mouse", "09-mouse"}})
    models.push_back(model_of(name, read_scene(examples + folder + "/scene.toml")));
  const fs::path sketches = batten_test::optional_data("sketch-cassie/sketch_graph");
  if (sketches.empty())
    std::printf("No sketches: sketch-cassie is missing (set BATTEN_TEST_DATA)\n");
  else
    for (const char* name : {"teapot", "computer-mouse"})
      models.push_back(
          model_of(std::string("sketch ") + name,
                   scene_of_lines({sketches / (std::string(name) + ".json")}, {}, "m")));
  return models;
}

const Surface& onto_surface(const Model& model, const std::string& name) {
  for (const SkinnedRegion* region : model.regions())
    if (region->name == name) return region->surface;
  throw Error("found no face '" + name + "'");
}

/// Largest distance of points of the file's faces from the surfaces, in model units.
double beyond_surfaces(const Model& model, const fs::path& file, const StepReport& report,
                       int count) {
  std::map<std::string, std::unique_ptr<SurfaceProjector>> projectors;
  for (const SkinnedRegion* region : model.regions())
    projectors[region->name] = std::make_unique<SurfaceProjector>(region->surface);
  const OccStepFile step(file.string(), model.unit);
  const int faces_read = std::min(step.faces(), static_cast<int>(report.patches.size()));
  const int n = std::max(4, static_cast<int>(std::sqrt(count / std::max(1, faces_read))));
  double most = 0;
  for (int f = 0; f < faces_read; ++f) {
    std::vector<Vec3> points = step.points(f, n);
    for (const Vec3& p : step.rim(f, n)) points.push_back(p);
    const SurfaceProjector& onto = *projectors.at(report.patches[static_cast<size_t>(f)].region);
    const Surface& surface = onto_surface(model, report.patches[static_cast<size_t>(f)].region);
    for (const Vec3& p : points) {
      double away = onto.nearest(p).distance;
      // A full closest-point search if the quick search may have ended at another local minimum.
      if (away > report.tolerance) away = std::min(away, surface.closest_point(p).distance);
      most = std::max(most, away);
    }
  }
  return most;
}

struct Options {
  int points = 100'000;
  bool brief = false;  ///< without facets
  fs::path folder;
};

double megabytes(const fs::path& file) { return 1e-6 * static_cast<double>(fs::file_size(file)); }
std::string short_text(double x) { return text("%.2g", x); }

void few_faces(const Model& model, const Options& options, Checks& checks, Table& table,
               Table& facetted) {
  const auto regions = model.regions();
  std::optional<StepCrossCheck> cross_check;
  for (const double share : {1e-2, 1e-3, 1e-4, 1e-5}) {
    StepFaceOptions o;
    o.tolerance = share * model.size;
    o.analytic = false;  // the cross-check evaluates B-splines
    const fs::path file = options.folder / (model.name + text("_%g.step", share));
    StepReport report;
    const auto once = [&] {
      return cpu_seconds_of([&] { report = write_step_faces(file, regions, model.unit, o); });
    };
    constexpr double short_work = 1;
    double write = once();
    if (write < short_work) write = median({write, once(), once()});
    const double read = cpu_seconds_of([&] { OccStepFile(file.string(), model.unit); });
    if (!cross_check) cross_check.emplace(regions, report.joins, options.points, options.folder);
    const auto seen = cross_check->seen(file);
    const double back = beyond_surfaces(model, file, report, options.points / 5);
    long poles = 0;
    for (const StepPatch& patch : report.patches) poles += long{patch.poles_u} * patch.poles_v;
    double surface_deg = 0;
    for (const StepJoin& join : report.joins) surface_deg = std::max(surface_deg, join.surface_deg);
    const double worst = std::max({*report.max_deviation, back, seen ? seen->distance : 0.0});
    long missed = std::count_if(report.joins.begin(), report.joins.end(),
                                [](const StepJoin& join) { return !join.reached; });
    table.add({model.name, short_text(share), std::to_string(report.faces),
               text("%.2g", *report.max_deviation / o.tolerance), text("%.2g", back / o.tolerance),
               seen ? text("%.2g", seen->distance / o.tolerance) : "-",
               std::to_string(report.joins.size()), std::to_string(missed),
               short_text(report.max_join_deg), seen ? std::to_string(seen->above) : "-",
               seen ? short_text(seen->degrees) : "-", short_text(surface_deg),
               std::to_string(poles), text("%.2f", megabytes(file)), text("%.2f", write),
               text("%.2f", read), report.valid ? "yes" : "no"});
    const std::string name = model.name + text(" at %g of the size: ", share);
    checks.at_most(name + "deviation over requested", worst / o.tolerance, 1);
    checks.at_most(name + "degrees across smooth edges", report.max_join_deg, 0.1);
    checks.at_most(name + "faces that are missing or extra",
                   std::abs(report.faces - static_cast<int>(regions.size())), 0);
    // Finer ones take minutes in OpenCASCADE's mesher, and files of a hundred megabytes.
    if (share < 1e-4 || options.brief) continue;
    const OccStepFile::Facets facets =
        OccStepFile(file.string(), model.unit).facets(std::max(0.0, o.tolerance - worst / 2));
    const fs::path flat = options.folder / "facets.step";
    constexpr size_t most = 20'000;
    const size_t count = facets.triangles.size();
    if (count == 0) continue;
    double flat_write = 0, flat_read = 0, mb = 0;
    if (count <= most) {
      flat_write = cpu_seconds_of([&] { write_facetted(flat.string(), facets, model.unit); });
      flat_read = cpu_seconds_of([&] { OccStepFile(flat.string(), model.unit); });
      mb = megabytes(flat);
    }
    facetted.add({model.name, short_text(share), std::to_string(count),
                  mb > 0 ? text("%.2f", mb) : "too many", text("%.2f", megabytes(file)),
                  text("%.2f", flat_write), text("%.2f", write), text("%.2f", flat_read),
                  text("%.2f", read)});
    if (mb == 0) continue;
    checks.at_most(name + "megabytes over those of facets", megabytes(file) / mb, 1);
    checks.at_most(name + "seconds to write and read over those of facets",
                   (write + read) / (flat_write + flat_read), 1);
  }
}

void exact_form(const Model& model, const Options& options, Checks& checks, Table& table) {
  const fs::path file = options.folder / (model.name + "_exact.step");
  StepOptions o;
  StepReport report;
  double write = 0;
  try {
    write = cpu_seconds_of([&] { report = write_step(file, model.regions(), model.unit, o); });
  } catch (const InputError&) {
    table.add({model.name, "none: cut by embedded curves"});
    return;
  }
  const double read = cpu_seconds_of([&] { OccStepFile(file.string(), model.unit); });
  double fitted = 0;
  for (const StepPatch& patch : report.patches) fitted = std::max(fitted, patch.deviation);
  table.add({model.name, std::to_string(report.faces), std::to_string(report.patches.size()),
             short_text(*report.max_deviation / model.size), short_text(fitted / model.size),
             short_text(report.max_normal_jump_deg), short_text(report.max_join_deg),
             text("%.1f", megabytes(file)), text("%.2f", write), text("%.2f", read),
             text("%.0f", report.faces / write), text("%.0f", report.faces / read)});
  checks.at_most(model.name + ", exact: deviation over the size",
                 *report.max_deviation / model.size, 1e-12);
}

/// Gmsh reads a file, writes it, and meshes it.
void gmsh_conversion(const Model& model, const fs::path& file, const fs::path& folder,
                     Checks& checks, Table& table) {
  const fs::path other = folder / "converted.step", said = folder / "gmsh.txt";
  fs::remove(other);
  const std::string command = "/usr/bin/python3 " BATTEN_BENCH_GMSH_PY " '" + file.string() +
                              "' '" + other.string() + "' 2> /dev/null | tail -1 > '" +
                              said.string() + "'";
  double read = 0, write = 0, faces = 0, triangles = 0, warnings = 0;
  if (std::system(command.c_str()) != 0 ||
      !(std::ifstream(said) >> read >> write >> faces >> triangles >> warnings)) {
    table.add({file.stem().string(), "Gmsh", "none (python3-gmsh)"});
    return;
  }
  table.add({file.stem().string(), "Gmsh", text("%.0f", faces), text("%.2f", read),
             text("%.2f", write), fs::exists(other) ? text("%.2f", megabytes(other)) : "-",
             text("%.0f triangles, %.0f warnings", triangles, warnings)});
  checks.at_most(file.stem().string() + ": warnings of Gmsh", warnings, 0);
  checks.at_most(file.stem().string() + ": faces missing in Gmsh",
                 std::abs(faces - static_cast<double>(model.regions().size())), 0);
}

/// FreeCAD reads a file and checks it.
void freecad_check(const fs::path& file, const fs::path& folder, Table& table) {
  const fs::path said = folder / "freecad.txt";
  const std::string command = "STEP_FILES='" + file.string() +
                              "' freecadcmd " BATTEN_BENCH_FREECAD_PY " 2> /dev/null | grep '^" +
                              file.filename().string() + "' > '" + said.string() + "'";
  std::string line;
  if (std::system(command.c_str()) != 0 || !std::getline(std::ifstream(said) >> std::ws, line)) {
    table.add({file.stem().string(), "FreeCAD", "none (freecad)"});
    return;
  }
  table.add({file.stem().string(), "FreeCAD", "", "", "", "",
             line.substr(std::min(line.size(), file.filename().string().size() + 1))});
}

/// Some files, read and written by Gmsh, OpenCASCADE and FreeCAD.
void conversions(const Model& model, const Options& options, Checks& checks, Table& table) {
  for (const double share : {1e-2, 1e-3, 1e-4, 1e-5}) {
    const fs::path file = options.folder / (model.name + text("_%g.step", share));
    const fs::path other = options.folder / "converted.step";
    std::unique_ptr<OccStepFile> step;
    const double read =
        cpu_seconds_of([&] { step = std::make_unique<OccStepFile>(file.string(), model.unit); });
    if (step->faces() > 0) {
      const double write = cpu_seconds_of([&] { step->write(other.string()); });
      table.add({file.stem().string(), "OpenCASCADE", std::to_string(step->faces()),
                 text("%.2f", read), text("%.2f", write), text("%.2f", megabytes(other)),
                 step->valid() ? "valid" : "not valid"});
    }
    gmsh_conversion(model, file, options.folder, checks, table);
    freecad_check(file, options.folder, table);
  }
}

/// OpenCASCADE's filling of the same boundary curves, face by face: the distance from them that it
/// reports, and the actual one.
void fillings(const Model& model, Table& table) {
  for (const double share : {1e-4}) {
    double worst = 0, seconds_taken = 0;
    int done = 0, all = 0;
    long poles = 0;
    for (const SkinnedRegion* region : model.regions()) {
      std::vector<std::vector<HermiteCurve>> loops;
      for (const auto& pieces : region->boundary) {
        loops.emplace_back();
        for (const BoundarySegment& piece : pieces)
          loops.back().push_back(boundary_curve(*region, piece));
      }
      ++all;
      std::unique_ptr<OccFilling> filling;
      const bool closed = std::any_of(loops.begin(), loops.end(), [](const auto& loop) {
        return loop.size() == 1 && loop[0].closed();
      });
      if (closed) continue;  // it does not accept a single closed edge
      seconds_taken += cpu_seconds_of([&] {
        filling = std::make_unique<OccFilling>(loops, std::vector<HermiteCurve>{},
                                               OccFillingSettings{"", share * model.size, 15, 9});
      });
      if (!filling->done()) continue;
      ++done;
      poles += long{filling->poles()[0]} * filling->poles()[1];
      for (const auto& loop : loops)
        for (const HermiteCurve& c : loop)
          for (int k = 0; k <= 40; ++k)
            worst = std::max(
                worst, filling->distance(c.evaluate(c.start() + (c.end() - c.start()) * k / 40.0)));
    }
    table.add({model.name, short_text(share), text("%d of %d", done, all),
               done ? text("%.3g", worst / model.size / share) : "-", std::to_string(poles),
               text("%.2f", seconds_taken)});
  }
}

}  // namespace

/// usage: bench_step [POINTS [MODEL [brief]]]
int main(int argc, char** argv) {
  one_thread();
  Options options;
  if (argc > 1) options.points = std::atoi(argv[1]);
  const std::string only = argc > 2 ? argv[2] : "";
  options.brief = argc > 3;
  options.folder = fs::temp_directory_path() / ("batten_bench_step_" + std::to_string(::getpid()));
  fs::create_directories(options.folder);
  Checks checks;
  Table few, facetted, exact, converted, filled;
  few.add({"one face per face", "requested", "faces", "deviation over requested", "back",
           "cross-check", "edges", "missed", "degrees", "cross-check", "degrees", "of surfaces",
           "poles", "MB", "write s", "read s", "valid"});
  facetted.add({"faceted", "requested", "triangles", "MB", "Batten", "write s", "Batten", "read s",
                "Batten"});
  exact.add({"exact", "faces", "fitted", "deviation", "of fitted", "degrees inside",
             "degrees, edges", "MB", "write s", "read s", "faces/s", "read/s"});
  converted.add({"converted", "by", "faces", "read s", "write s", "MB", ""});
  filled.add(
      {"filling", "requested", "done", "distance from curves over requested", "poles", "seconds"});
  std::printf("Processor time on one thread; writing includes reading back and measuring.\n\n");
  for (const auto& model : all_models()) {
    if (model->name.find(only) == std::string::npos) continue;
    std::fprintf(stderr, "%s\n", model->name.c_str());
    few_faces(*model, options, checks, few, facetted);
    exact_form(*model, options, checks, exact);
    conversions(*model, options, checks, converted);
    if (!occ_version().empty()) fillings(*model, filled);
  }
  for (const Table* table : {&few, &exact, &facetted, &converted, &filled}) table->print();
  fs::remove_all(options.folder);
  checks.print("step");
}
