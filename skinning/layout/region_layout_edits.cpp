// Edits of a layout: made on a copy of its parts, which takes their place when nothing was thrown.
#include "batten/skinning/layout/region_layout.h"

#include <algorithm>
#include <cctype>

#include "batten/core/errors.h"
#include "batten/core/isize.h"
#include "batten/skinning/domains/annulus_domain.h"
#include "batten/skinning/domains/domain_input.h"

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
template <class Geometry>
auto find_line(Geometry& geometry, const std::string& name)
    -> decltype(&geometry.edge_aligned[0].fitted) {
  for (auto& aligned_line : geometry.edge_aligned)
    if (aligned_line.line.name == name) return &aligned_line.fitted;
  for (auto& line : geometry.embedded)
    if (line.line.name == name) return &line.fitted;
  return nullptr;
}

void erase_embedded(RegionGeometry& geometry, size_t index) {
  geometry.embedded.erase(geometry.embedded.begin() + static_cast<long>(index));
  for (auto& segments : geometry.boundary)
    for (BoundarySegment& piece : segments)
      if (piece.kind == BoundarySegment::Kind::Embedded && piece.index > static_cast<int>(index))
        --piece.index;
}

[[noreturn]] void no_such_line(const std::string& region, const std::string& name,
                               const std::vector<std::string>& names) {
  const std::string near = closest_match(name, names);
  throw InputError("region '" + region + "' has no line '" + name + "'" +
                   (near.empty() ? "" : ": did you mean '" + near + "'?"));
}

}  // namespace

std::vector<std::string> RegionLayout::line_names() const {
  std::vector<std::string> names;
  for (const EdgeAlignedLine& aligned_line : geometry_.edge_aligned)
    names.push_back(aligned_line.line.name);
  for (const EmbeddedLine& line : geometry_.embedded) names.push_back(line.line.name);
  return names;
}

bool RegionLayout::has_line(const std::string& name) const {
  return find_line(geometry_, name) != nullptr;
}

const HermiteCurve& RegionLayout::line(const std::string& name) const {
  const HermiteCurve* found = find_line(geometry_, name);
  if (!found) no_such_line(name_, name, line_names());
  return *found;
}

bool RegionLayout::refine(const std::vector<char>& marked) {
  if (isize(marked) != mesh()->triangle_count())
    throw InputError(std::to_string(marked.size()) + " marks for " +
                     std::to_string(mesh()->triangle_count()) + " triangles");
  if (std::none_of(marked.begin(), marked.end(), [](char m) { return m != 0; })) return false;
  RegionGeometry geometry = geometry_;
  bisect_marked(geometry, marked);
  if (!geometry.embedded.empty()) trim_and_collocate(geometry, task());
  geometry_ = std::move(geometry);
  return true;
}

void RegionLayout::set_line(const std::string& name, HermiteCurve curve) {
  const CurveMesh &old = line(name).mesh(), &prescribed = curve.mesh();
  if (prescribed.parameters() != old.parameters() || prescribed.closed() != old.closed() ||
      prescribed.corners() != old.corners())
    throw InputError(
        "line '" + name + "' has " + std::to_string(old.segment_count()) + " segments over [" +
        format_number(old.start()) + ", " + format_number(old.end()) +
        "]: its new shape must have the same nodes, parameters and corners, and has " +
        std::to_string(prescribed.segment_count()) + " segments over [" +
        format_number(prescribed.start()) + ", " + format_number(prescribed.end()) + "]");
  auto input = curve_from_hermite(curve);
  const auto set = [&](auto& entry) {
    if (entry.line.name != name) return;
    entry.line.curve = std::move(input);
    entry.fitted = std::move(curve);
  };
  // Names are unique: the first match takes the curve.
  for (EdgeAlignedLine& aligned_line : geometry_.edge_aligned) set(aligned_line);
  for (EmbeddedLine& embedded : geometry_.embedded) set(embedded);
}

void RegionLayout::add_inner_line(const CharacterLine& line, const Surface& shape) {
  if (line.role != CharacterLine::Role::Inner)
    throw InputError("line '" + line.name +
                     "' is not an inner line: outlines and holes are there "
                     "from the beginning");
  if (line.mesh_alignment == CharacterLine::MeshAlignment::EdgeAligned)
    throw InputError("line '" + line.name +
                     "' cannot be fitted: lines that are added later are embedded");
  if (&shape.mesh() != geometry_.mesh.get())
    throw InputError("line '" + line.name +
                     "': the shape that it is put on has another mesh than "
                     "region '" +
                     name_ + "'");
  const std::vector<SmoothSegment> segments = split_at_corners(line, options_.corner_angle);
  for (const std::string& other : line_names())
    for (const SmoothSegment& segment : segments)
      if (other == segment.name || other == line.name || is_piece_of(other, line.name))
        throw InputError("two lines have the name '" + other + "'");
  RegionGeometry geometry = geometry_;
  if (geometry.mesh->period() > 0)
    embed_on_annulus(shape, {}, segments, task(), geometry);
  else
    embed_on_surface(shape, {}, segments, task(), geometry);
  trim_and_collocate(geometry, task());
  geometry_ = std::move(geometry);
}

void RegionLayout::remove_inner_line(const std::string& name) {
  const std::vector<char> bounds = boundary_line_flags(geometry_);
  const bool whole = has_line(name);
  RegionGeometry geometry = geometry_;
  bool found = false;
  for (size_t i = geometry_.embedded.size(); i-- > 0;) {
    const std::string& other = geometry_.embedded[i].line.name;
    if (bounds[i] || !(whole ? other == name : is_piece_of(other, name))) continue;
    erase_embedded(geometry, i);
    found = true;
  }
  if (!found && whole)
    throw InputError("line '" + name +
                     "' cannot be taken out: it bounds the region, or the mesh runs along it");
  if (!found) no_such_line(name_, name, line_names());
  if (!geometry.embedded.empty()) trim_and_collocate(geometry, task());
  geometry_ = std::move(geometry);
}

}  // namespace batten
