#include "batten/apps/commands/cad_info.h"

#include "batten/core/errors.h"
#include "batten/io/files/in_child.h"
#include "batten/io/files/length_units.h"
#include "batten/io/files/text.h"
#include "batten/io/lines/cad_calls.h"
#include "batten/io/pictures/display.h"
#include "batten/io/pictures/edge_pictures.h"

namespace batten {
namespace {

// "" for a file without faces.
std::string step_text(const std::filesystem::path& file, const std::string& unit) {
  const StepReport step = cad_calls().check_step(file, unit_in_metres(unit), {});
  if (step.faces == 0) return "";
  return std::to_string(step.faces) + " faces in " + std::to_string(step.shells) +
         " shells, lengths in " + unit + "\n  " + (step.valid ? "valid" : "NOT valid") + ", area " +
         number(step.area) + "\n";
}

EdgeComb comb_of(const EdgeContinuity& edge) {
  using Kind = EdgeContinuity::Kind;
  EdgeComb comb;
  comb.kind = edge.kind == Kind::Crease    ? EdgeComb::Kind::Crease
              : edge.kind == Kind::Tangent ? EdgeComb::Kind::Tangent
                                           : EdgeComb::Kind::Curvature;
  for (const EdgeTooth& tooth : edge.teeth) {
    comb.line.push_back(tooth.at);
    for (size_t side = 0; side < 2; ++side) comb.bends[side].push_back(tooth.bend[side]);
  }
  return comb;
}

}  // namespace

bool is_step_file(const std::filesystem::path& file) {
  const std::string ending = lower_extension(file);
  return ending == ".step" || ending == ".stp";
}

bool is_cad_file(const std::filesystem::path& file) {
  const std::string ending = lower_extension(file);
  return is_step_file(file) || ending == ".iges" || ending == ".igs";
}

std::string faces_text(const std::filesystem::path& file, const std::string& unit) {
  if (cad_calls().read_cad_surfaces(file, unit_in_metres(unit)).empty()) return "";
  const ContinuityReport report =
      cad_calls().measure_continuity(file, unit_in_metres(unit), ContinuityOptions{});
  return (is_step_file(file)
              ? bytes_from_child(file, "OpenCASCADE", [&] { return step_text(file, unit); })
              : std::to_string(report.faces) + " faces, lengths in " + unit + "\n") +
         continuity_text(report, ContinuityOptions{}, unit);
}

bool draw_face_edges(const std::filesystem::path& picture, const std::filesystem::path& file,
                     const std::string& unit) {
  if (!is_cad_file(file) || cad_calls().read_cad_surfaces(file, unit_in_metres(unit)).empty())
    return false;
  require_display();
  ContinuityOptions options;
  options.teeth = 40;
  const ContinuityReport report =
      cad_calls().measure_continuity(file, unit_in_metres(unit), options);
  EdgePicture drawing;
  drawing.title = file.filename().string() + ": curvature across edges";
  drawing.unit = unit;
  for (const EdgeContinuity& edge : report.inner) drawing.edges.push_back(comb_of(edge));
  drawing.rims = report.rim_lines;
  draw_edge_combs(picture, drawing);
  return true;
}

}  // namespace batten
