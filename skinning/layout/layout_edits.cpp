// Edits of a layout: made on a copy of its parts, which takes their place when nothing was thrown.
#include "batten/skinning/layout/region_layout.h"

#include <algorithm>
#include <cctype>

#include "batten/core/errors.h"
#include "batten/core/index.h"
#include "batten/skinning/domains/domain_task.h"
#include "batten/skinning/domains/ring.h"

namespace batten {
namespace {

// "rib" itself, or "rib.1", "rib.2", … which a line is cut into at its corners.
bool is_piece_of(const std::string& name, const std::string& line) {
  if (name.size() < line.size() + 2 || name.compare(0, line.size(), line) != 0) return false;
  return name[line.size()] == '.' &&
         std::all_of(name.begin() + static_cast<long>(line.size()) + 1, name.end(),
                     [](unsigned char c) { return std::isdigit(c); });
}

// Of a run or an embedded line, or null.
template <class Parts>
auto find_line(Parts& parts, const std::string& name) -> decltype(&parts.runs[0].fitted) {
  for (auto& run : parts.runs)
    if (run.line.name == name) return &run.fitted;
  for (auto& line : parts.embedded)
    if (line.line.name == name) return &line.fitted;
  return nullptr;
}

void erase_embedded(RegionParts& parts, size_t index) {
  parts.embedded.erase(parts.embedded.begin() + static_cast<long>(index));
  for (auto& pieces : parts.boundary)
    for (BoundaryPiece& piece : pieces)
      if (piece.kind == BoundaryPiece::Kind::Embedded && piece.index > static_cast<int>(index))
        --piece.index;
}

[[noreturn]] void no_such_line(const std::string& region, const std::string& name,
                               const std::vector<std::string>& names) {
  const std::string near = nearest_word(name, names);
  throw InputError("region '" + region + "' has no line '" + name + "'" +
                   (near.empty() ? "" : ": did you mean '" + near + "'?"));
}

}  // namespace

std::vector<std::string> RegionLayout::line_names() const {
  std::vector<std::string> names;
  for (const LineRun& run : parts_.runs) names.push_back(run.line.name);
  for (const EmbeddedLine& line : parts_.embedded) names.push_back(line.line.name);
  return names;
}

bool RegionLayout::has_line(const std::string& name) const {
  return find_line(parts_, name) != nullptr;
}

const HermiteCurve& RegionLayout::line(const std::string& name) const {
  const HermiteCurve* found = find_line(parts_, name);
  if (!found) no_such_line(name_, name, line_names());
  return *found;
}

bool RegionLayout::refine(const std::vector<char>& marked) {
  if (count_of(marked) != mesh()->triangle_count())
    throw InputError(std::to_string(marked.size()) + " marks for " +
                     std::to_string(mesh()->triangle_count()) + " triangles");
  if (std::none_of(marked.begin(), marked.end(), [](char m) { return m != 0; })) return false;
  RegionParts parts = parts_;
  halve(parts, marked);
  if (!parts.embedded.empty()) cut_and_place(parts, task());
  parts_ = std::move(parts);
  return true;
}

void RegionLayout::set_line(const std::string& name, HermiteCurve curve) {
  const CurveMesh &old = line(name).mesh(), &given = curve.mesh();
  if (given.parameters() != old.parameters() || given.closed() != old.closed() ||
      given.corners() != old.corners())
    throw InputError("line '" + name + "' has " + std::to_string(old.segment_count()) +
                     " segments over [" + number(old.start()) + ", " + number(old.end()) +
                     "]: its new shape must have the same nodes, parameters and corners, and has " +
                     std::to_string(given.segment_count()) + " segments over [" +
                     number(given.start()) + ", " + number(given.end()) + "]");
  auto input = curve_from_hermite(curve);
  const auto set = [&](auto& held) {
    if (held.line.name != name) return;
    held.line.curve = std::move(input);
    held.fitted = std::move(curve);
  };
  // Names are unique: the first match takes the curve.
  for (LineRun& run : parts_.runs) set(run);
  for (EmbeddedLine& embedded : parts_.embedded) set(embedded);
}

void RegionLayout::add_inner(const CharacterLine& line, const Surface& shape) {
  if (line.role != CharacterLine::Role::Inner)
    throw InputError("line '" + line.name +
                     "' is not an inner line: outlines and holes are there "
                     "from the beginning");
  if (line.treatment == CharacterLine::Treatment::Fitted)
    throw InputError("line '" + line.name +
                     "' cannot be fitted: lines that are added later are embedded");
  if (&shape.mesh() != parts_.mesh.get())
    throw InputError("line '" + line.name +
                     "': the shape that it is put on has another mesh than "
                     "region '" +
                     name_ + "'");
  const std::vector<Stretch> stretches = cut_at_corners(line, options_.corner_angle);
  for (const std::string& other : line_names())
    for (const Stretch& stretch : stretches)
      if (other == stretch.name || other == line.name || is_piece_of(other, line.name))
        throw InputError("two lines have the name '" + other + "'");
  RegionParts parts = parts_;
  if (parts.mesh->period() > 0)
    embed_on_ring(shape, {}, stretches, task(), parts);
  else
    embed_on(shape, {}, stretches, task(), parts);
  cut_and_place(parts, task());
  parts_ = std::move(parts);
}

void RegionLayout::remove_inner(const std::string& name) {
  const std::vector<char> bounds = boundary_lines(parts_);
  const bool whole = has_line(name);
  RegionParts parts = parts_;
  bool found = false;
  for (size_t i = parts_.embedded.size(); i-- > 0;) {
    const std::string& other = parts_.embedded[i].line.name;
    if (bounds[i] || !(whole ? other == name : is_piece_of(other, name))) continue;
    erase_embedded(parts, i);
    found = true;
  }
  if (!found && whole)
    throw InputError("line '" + name +
                     "' cannot be taken out: it bounds the region, or the mesh runs along it");
  if (!found) no_such_line(name_, name, line_names());
  if (!parts.embedded.empty()) cut_and_place(parts, task());
  parts_ = std::move(parts);
}

}  // namespace batten
