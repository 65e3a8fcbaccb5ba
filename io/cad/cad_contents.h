// What is in a CAD file: products and their places, names, colours, layers, unit, counts.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "batten/core/eigen.h"

namespace batten {

/// One place of a product: an assembly, a part of it, or a shape that stands alone. A product that
/// is used three times is there three times.
struct CadProduct {
  std::string name;           ///< of the product; "" for none
  std::string instance_name;  ///< the name of this instance where it has another one
  int level = 0;              ///< how deep it is in the assembly, 0 at the top
  bool assembly = false;
  Vec3 translation = Vec3::Zero();        ///< where its origin lies in the whole, the file's unit
  double rotation_deg = 0;                ///< by how much it is turned in the whole
  std::string colour;                     ///< its own, "#rrggbb"; "" for none
  int solids = 0, faces = 0, curves = 0;  ///< 0 of an assembly
};

/// A name, colour or layer, and what has it.
struct CadAttribute {
  std::string name;
  int products = 0;  ///< of a layer
  int solids = 0;    ///< solids and shells within a product
  int faces = 0;
  int edges = 0;   ///< edges of faces
  int curves = 0;  ///< edges that belong to no face
};

/// What is in a CAD file. Lengths are in the file's own unit; instances count each.
struct CadContents {
  std::string format;            ///< "STEP AP214", "IGES", "BREP", …
  double unit_in_metres = 1e-3;  ///< of the lengths in the file
  bool unit_stated = false;      ///< whether the file says it
  std::vector<std::string> notes;
  std::vector<CadProduct> products;
  std::vector<CadAttribute> names;    ///< of all but products, in the file's order
  std::vector<CadAttribute> colours;  ///< "#rrggbb" as faces and curves have it, own or inherited
  std::vector<CadAttribute> layers;
  int solids = 0, shells = 0, faces = 0, edges = 0;
  int closed_shells = 0;  ///< shells without a rim
  int curves = 0;         ///< edges that belong to no face
  double area = 0;
  double trim_uncertainty_area =
      0;              ///< lengths of edges times their tolerances: by so much trims are not known
  double volume = 0;  ///< of all solids, unit³
  double size = 0;    ///< diagonal of the box around all
};

}  // namespace batten
