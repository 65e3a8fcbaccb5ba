#include "batten/io/cad/cad_contents_bytes.h"

#include <nlohmann/json.hpp>

#include "batten/core/errors.h"

namespace Eigen {

void to_json(nlohmann::json& json, const Eigen::Vector3d& p) { json = {p.x(), p.y(), p.z()}; }
void from_json(const nlohmann::json& json, Eigen::Vector3d& p) {
  p = {json.at(0).get<double>(), json.at(1).get<double>(), json.at(2).get<double>()};
}

}  // namespace Eigen

namespace batten {

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(CadProduct, name, instance_name, level, assembly, translation,
                                   rotation_deg, colour, solids, faces, curves)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(CadAttribute, name, products, solids, faces, edges, curves)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(CadContents, format, unit_in_metres, unit_stated, notes,
                                   products, names, colours, layers, solids, shells, faces, edges,
                                   closed_shells, curves, area, trim_uncertainty_area, volume, size)

std::string to_bytes(const CadContents& contents) {
  // Names of damaged files may be no UTF-8.
  return nlohmann::json(contents).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

CadContents contents_from_bytes(const std::string& bytes) {
  try {
    return nlohmann::json::parse(bytes).get<CadContents>();
  } catch (const nlohmann::json::exception&) {  // numbers that are not finite become null
    throw InputError("OpenCASCADE measures sizes that are not finite");
  }
}

}  // namespace batten
