#include "batten/io/scene/scene_area.h"

namespace batten {

SceneArea read_area(const TomlTable& table) {
  SceneArea area;
  if (table.has("near") && table.has("paint"))
    table.fail("paint", "both 'near' and 'paint'", "one of them");
  if (table.has("near")) {
    area.line = {table.text("near"), table.location("near")};
    area.area.where = Area::NearLine{area.line.text, table.positive("radius")};
  } else if (table.has("radius")) {
    table.fail("radius", "'radius' without 'near'", "both, or 'paint'");
  }
  if (table.has("paint")) {
    Area::Painted painted;
    for (const TomlTable& t : table.tables("paint", {"at", "radius", "strength"}))
      painted.strokes.push_back({t.vector("at"), t.positive("radius"), t.number("strength", 1)});
    if (painted.strokes.empty())
      table.fail("paint", "no strokes", "one or more: paint = [{at = […], radius = …}]");
    area.area.where = painted;
  }
  if (table.has("regions")) {
    area.regions = table.words("regions");
    if (area.regions.empty())
      table.fail("regions", "no regions", "names: regions = [\"a\", \"b\"]; all without the key");
  }
  return area;
}

}  // namespace batten
