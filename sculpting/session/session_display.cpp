#include "batten/core/isize.h"
#include "batten/sculpting/session/session_data.h"
#include "batten/skinning/facets/facets.h"

namespace batten {

SkinnedRegion SessionData::skinned_region(int r) {
  SkinnedRegion region = layout().skinned(r, absolute(now.shape.x));
  const auto moved = [&](CharacterLine& line, HermiteCurve& fitted, bool embedded, size_t index) {
    const auto& moves = system().def.moves;
    if (std::none_of(moves.begin(), moves.end(),
                     [&](const auto& m) { return m->move.line == line.name; }))
      return;
    fitted = this->line(line.name);
    if (layout().against(layout().model_line(line.name), {r, embedded, static_cast<int>(index)}))
      fitted = fitted.backwards();
    line.curve = curve_from_hermite(fitted);
  };
  for (size_t i = 0; i < region.edge_aligned.size(); ++i)
    moved(region.edge_aligned[i].line, region.edge_aligned[i].fitted, false, i);
  for (size_t i = 0; i < region.embedded.size(); ++i) {
    EmbeddedLine& line = region.embedded[i];
    moved(line.line, line.fitted, true, i);
    // An image of the same nodes.
    if (line.pcurve.parameters() != line.fitted.parameters())
      line.pcurve = line.pcurve.with_nodes(line.fitted.parameters());
  }
  return region;
}

void SessionData::draw(Frame& to) {
  if (display.mesh != layout().mesh()) {
    auto pattern = std::make_shared<DisplayTopology>();
    std::vector<Location>& locations = pattern->locations;
    for (int r = 0; r < layout().region_count(); ++r) {
      DisplayFacets own = facets(skinned_region(r), options.facets_per_edge);
      const int first = isize(locations);
      pattern->first_facet.push_back(isize(pattern->facets));
      pattern->first_line.push_back(isize(pattern->lines));
      for (const Location& where : own.tessellation.points)
        locations.push_back(layout().to_model_location(r, where));
      for (auto facet : own.tessellation.facets) {
        for (int& corner : facet) corner += first;
        pattern->facets.push_back(facet);
      }
      for (auto& line : own.lines) {
        for (auto& piece : line)
          for (int& point : piece) point += first;
        pattern->lines.push_back(std::move(line));
      }
    }
    pattern->first_facet.push_back(isize(pattern->facets));
    pattern->first_line.push_back(isize(pattern->lines));
    display.pattern = pattern;
    display.points =
        std::make_unique<DisplayPoints>(*layout().mesh(), layout().element(), locations);
    display.mesh = layout().mesh();
  }
  to.remeshed = to.pattern != display.pattern;
  to.pattern = display.pattern;
  const auto count = 3 * static_cast<size_t>(display.points->count());
  to.points.resize(count);
  to.normals.resize(count);
  to.moved = to.remeshed || shown != version;
  to.number = ++frames;
  display.points->evaluate(now.shape.x, system().origin(), to.points.data(), to.normals.data());
  shown = version;
}

}  // namespace batten
