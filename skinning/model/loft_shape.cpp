#include "batten/skinning/model/loft_shape.h"

#include <algorithm>
#include <set>

#include "batten/core/errors.h"
#include "batten/core/format.h"
#include "batten/core/parallel_chunks.h"
#include "batten/skinning/model/section_surface.h"

namespace batten {
namespace {

// Whether a line is a section, or a part of one: "root.2" of the line "root" that was cut at its
// corners. Takes the sections that it finds out of `missing`.
bool is_section(const std::string& name, const std::vector<std::string>& sections,
                std::set<std::string>& missing) {
  const auto it = std::find_if(sections.begin(), sections.end(), [&](const std::string& s) {
    return name == s || name.starts_with(s + ".");
  });
  if (it != sections.end()) missing.erase(*it);
  return it != sections.end();
}

// The side of a region with four corners that a section is part of, or -1.
int side_of_sections(const RegionLayout& region, const std::vector<std::string>& sections,
                     std::set<std::string>& missing) {
  int side = -1;
  for (const EmbeddedLine& line : region.embedded()) is_section(line.line.name, sections, missing);
  for (const EdgeAlignedLine& aligned_line : region.edge_aligned()) {
    if (!is_section(aligned_line.line.name, sections, missing) || is_annulus(region) ||
        region.corners().size() != 4 || aligned_line.line.role != CharacterLine::Role::Outline)
      continue;
    const int found = domain_side(region, aligned_line);
    if (side >= 0 && found % 2 != side % 2)
      throw InputError("the sections of region '" + region.name() +
                       "' are sides that meet, expected opposite sides: '" +
                       aligned_line.line.name + "'");
    side = found;
  }
  return side;
}

// Marks triangles whose dofs miss the surface through the sections inside by more than this.
void mark_misses(const RegionLayout& region, const SectionSurface& through, const Points& dofs,
                 double most, char* marks) {
  const Surface surface(region.mesh(), region.element(), dofs, region.trim());
  parallel_for_each<16>(surface.mesh().triangle_count(), [&](int t) {
    double miss = 0;
    for (const Vec3& L :
         {Vec3(1, 1, 1), Vec3(0.3, 1.35, 1.35), Vec3(1.35, 0.3, 1.35), Vec3(1.35, 1.35, 0.3)}) {
      const Vec2 uv = surface.mesh().shape(t).point(L / 3);
      miss = std::max(miss, (surface.position({t, L / 3}) - through.at(uv)).norm());
    }
    if (miss > most) marks[t] = 1;
  });
}

// The dofs to come near to: of the surfaces through the sections, 0 in other regions. Marks
// triangles if there is something to mark.
Points wanted_dofs(const ModelLayout& layout, const std::vector<std::string>& sections, double most,
                   std::vector<char>* marks) {
  std::set<std::string> missing(sections.begin(), sections.end());
  Points wanted = Points::Zero(layout.position_dofs().size(), 3);
  bool lofted = false;
  for (int r = 0; r < layout.region_count(); ++r) {
    const RegionLayout& region = layout.region(r);
    const int side = side_of_sections(region, sections, missing);
    if (!is_annulus(region) && side < 0) continue;
    lofted = true;
    const SectionSurface through(region, side);
    const Points own = through.dofs();
    for (int d = 0; d < own.rows(); ++d) wanted.row(layout.dof_offsets(r)(d)) = own.row(d);
    if (marks) mark_misses(region, through, own, most, marks->data() + layout.first_triangle(r));
  }
  if (!missing.empty())
    throw InputError("the section '" + *missing.begin() +
                     "' is no side of a region with four corners and no line in one");
  if (!lofted)
    throw InputError(
        "found nothing to loft, expected a ring, or sections: lines that are sides of "
        "a region with four corners (region '" +
        layout.region(0).name() + "' has " + std::to_string(layout.region(0).corners().size()) +
        ")");
  return wanted;
}

}  // namespace

Points loft_shape(const ModelLayout& layout, const std::vector<std::string>& sections) {
  return layout.nearest(wanted_dofs(layout, sections, 0, nullptr));
}

LoftedModel loft_model(std::shared_ptr<const ModelLayout> layout,
                       const std::vector<std::string>& sections, double most) {
  constexpr int kMaxRounds = 4;
  for (int round = 0;; ++round) {
    std::vector<char> marks(static_cast<size_t>(layout->mesh()->triangle_count()), 0);
    const Points wanted = wanted_dofs(*layout, sections, most, &marks);
    auto finer = std::make_shared<ModelLayout>(*layout);
    if (round == kMaxRounds || !finer->refine(marks)) return {layout, layout->nearest(wanted)};
    if (!finer->join_plans().empty()) finer->plan_joins(finer->minimize_energy({}));
    layout = std::move(finer);
  }
}

}  // namespace batten
