// Nothing of OpenCASCADE is here, so that programs that load it as a module have these words without it.
#include <cmath>
#include <nlohmann/json.hpp>

#include "batten/core/errors.h"
#include "batten/io/cad/cad_contents_bytes.h"

namespace Eigen {

void to_json(nlohmann::json& json, const Eigen::Vector3d& p) { json = {p.x(), p.y(), p.z()}; }
void from_json(const nlohmann::json& json, Eigen::Vector3d& p) {
  p = {json.at(0).get<double>(), json.at(1).get<double>(), json.at(2).get<double>()};
}

}  // namespace Eigen

namespace batten {

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(CadProduct, name, place, level, assembly, shift, turn_deg,
                                   colour, solids, faces)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(CadUse, name, products, solids, faces, edges, curves)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(CadContents, format, unit_in_metres, unit_stated, notes,
                                   products, names, colours, layers, solids, shells, faces, edges,
                                   closed_shells, curves, area, loose_area, volume,
                                   size)

std::string to_bytes(const CadContents& contents) {
  // Names of damaged files may be no UTF-8.
  return nlohmann::json(contents).dump(-1, ' ', false,
                                       nlohmann::json::error_handler_t::replace);
}

CadContents contents_from_bytes(const std::string& bytes) {
  try {
    return nlohmann::json::parse(bytes).get<CadContents>();
  } catch (const nlohmann::json::exception&) {  // numbers that are not finite become null
    throw InputError("OpenCASCADE measures sizes that are not finite");
  }
}

std::string unit_words(double unit_in_metres) {
  static constexpr std::pair<const char*, double> units[] = {
      {"mm", 1e-3},     {"cm", 1e-2},   {"m", 1},         {"in", 0.0254},   {"ft", 0.3048},
      {"um", 1e-6},     {"km", 1e3},    {"mi", 1609.344}, {"mil", 2.54e-5}, {"uin", 2.54e-8}};
  for (const auto& [name, metres] : units)
    if (std::abs(unit_in_metres - metres) <= 1e-9 * metres) return name;
  return number(unit_in_metres) + " m";
}

}  // namespace batten
