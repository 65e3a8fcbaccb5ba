// The shape that the boundary curves of each region mean, from which all else bends the surface.
#pragma once

#include <vector>

#include "batten/skinning/model/model_layout.h"

namespace batten {

/// Dofs of the rest shapes of all regions, 0 in regions that have none; no rows where none has, or
/// where ModelMetadata::rest or SkinOptions::rest is off. Absolute coordinates.
///
///     two, three or four sides   sweeps with transported sections (docs/theory/sweeps.md)
///     ring                       the loft through its rims and its closed inner curves
///     others                     none: five sides and more, a closed outline, a boundary in a plane
///
/// As the rest shape of ModelLayout::minimize_energy() it costs no energy: the surface is the rest shape
/// plus the displacement of least energy that inner curves, smooth joins and loads ask for.
/// O(vertices + edges) of these regions.
Points rest_dofs(const ModelLayout& layout);

/// The same where the rest shapes of the regions, one for each, are known.
Points rest_dofs(const ModelLayout& layout, const std::vector<const Points*>& of_regions);

/// The same of one region, in its own numbers; no rows: it has none.
Points rest_dofs(const RegionLayout& region);

/// Whether the region has five sides or more, not all in a plane. None of them is opposite to another,
/// so that there is nothing to sweep; among surfaces that all boundary curves allow, the one whose
/// curvature changes least (fair_model.h) is nearest to what is meant: docs/fairness.md has the table.
bool has_many_sides(const RegionLayout& region);

}  // namespace batten
