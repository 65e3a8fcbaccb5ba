#include "batten/io/meshes/abaqus_elements.h"

#include <array>
#include <map>
#include <string_view>

namespace batten {
namespace {

using Kind = NonShellElement::Kind;

struct Start {
  std::string_view name;
  Kind kind;
  int count;
  bool direction = false;
};

/// Types by how they begin; letters behind that say how they are integrated. The longer one of two
/// that begin the same stands first.
constexpr std::array kStarts{
    Start{"C3D10", Kind::Solid, 10},      Start{"C3D15", Kind::Solid, 15},
    Start{"C3D20", Kind::Solid, 20},      Start{"C3D27", Kind::Solid, 20},
    Start{"C3D4", Kind::Solid, 4},        Start{"C3D5", Kind::Solid, 5},
    Start{"C3D6", Kind::Solid, 6},        Start{"C3D8", Kind::Solid, 8},
    Start{"SC6", Kind::Solid, 6},         Start{"SC8", Kind::Solid, 8},
    Start{"CSS8", Kind::Solid, 8},        Start{"COH3D6", Kind::Solid, 6},
    Start{"COH3D8", Kind::Solid, 8},      Start{"B21", Kind::Beam, 2, true},
    Start{"B22", Kind::Beam, 3, true},    Start{"B23", Kind::Beam, 2, true},
    Start{"B31", Kind::Beam, 2, true},    Start{"B32", Kind::Beam, 3, true},
    Start{"B33", Kind::Beam, 2, true},    Start{"PIPE31", Kind::Beam, 2, true},
    Start{"PIPE32", Kind::Beam, 3, true}, Start{"FRAME3D", Kind::Beam, 2, true},
    Start{"RB3D2", Kind::Beam, 2},        Start{"T2D2", Kind::Beam, 2},
    Start{"T3D2", Kind::Beam, 2},         Start{"T3D3", Kind::Beam, 3},
    Start{"CONN3D2", Kind::Bush, 2},      Start{"CONN2D2", Kind::Bush, 2},
    Start{"SPRING1", Kind::Bush, 1},      Start{"SPRING", Kind::Bush, 2},
    Start{"DASHPOT1", Kind::Bush, 1},     Start{"DASHPOT", Kind::Bush, 2},
    Start{"GAP", Kind::Bush, 2},          Start{"JOINTC", Kind::Bush, 2},
    Start{"MASS", Kind::Mass, 1},         Start{"ROTARYI", Kind::Mass, 1},
    Start{"DCOUP3D", Kind::Other, 1},     Start{"R3D3", Kind::Other, 3},
    Start{"R3D4", Kind::Other, 4}};

const std::map<std::string, std::array<int, 2>> kFaces{
    {"S3", {3, 0}},     {"S3R", {3, 0}},   {"S3RS", {3, 0}},  {"STRI3", {3, 0}}, {"S4", {4, 0}},
    {"S4R", {4, 0}},    {"S4RS", {4, 0}},  {"S4RSW", {4, 0}}, {"S4R5", {4, 0}},  {"S6", {3, 3}},
    {"STRI65", {3, 3}}, {"S8", {4, 4}},    {"S8R", {4, 4}},   {"S8R5", {4, 4}},  {"M3D3", {3, 0}},
    {"M3D4", {4, 0}},   {"M3D4R", {4, 0}}, {"M3D6", {3, 3}},  {"M3D8", {4, 4}},  {"M3D8R", {4, 4}},
    {"CPS3", {3, 0}},   {"CPS4", {4, 0}},  {"CPS4R", {4, 0}}, {"CPS4I", {4, 0}}, {"CPS6", {3, 3}},
    {"CPS6M", {3, 3}},  {"CPS8", {4, 4}},  {"CPS8R", {4, 4}}};

}  // namespace

AbaqusElement abaqus_element(const std::string& type) {
  AbaqusElement element;
  if (const auto face = kFaces.find(type); face != kFaces.end()) {
    element.face = true;
    element.corners = face->second[0];
    element.middle = face->second[1];
    element.count = element.corners + element.middle;
    return element;
  }
  for (const Start& start : kStarts)
    if (type.starts_with(start.name)) {
      element.kind = start.kind;
      element.count = start.count;
      element.direction = start.direction;
      break;
    }
  return element;
}

}  // namespace batten
