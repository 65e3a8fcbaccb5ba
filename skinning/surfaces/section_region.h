// Lofts: detects curves that are sections of one shape, and makes regions from sections alone.
#pragma once

#include <string>
#include <vector>

#include "batten/core/progress.h"
#include "batten/skinning/layout/region_layout.h"
#include "batten/skinning/network/curve_network.h"

namespace batten {

/// Orders the curves of a network along a loft, if all of them are sections: no curve meets another
/// one, and either
///
///     all are closed and smooth, three or more: circles of a bottle, frames of a hull, a pipe;
///     all are closed with a corner at their seam, two or more: aerofoils;
///     all are open, two or more: stations, ribs.
///
/// The order is a chain of nearest neighbours. Each section has to face the next one. The planes of
/// closed sections may differ by at most 60° and must not coincide. The chords of open sections may
/// differ by at most 45° and must lie side by side. Otherwise the result is empty. It is also empty
/// for two closed smooth curves, which are the boundary circles of an annulus (find_regions()).
/// Cost: O(n²) for n curves.
std::vector<CharacterLine> ordered_sections(const CurveNetwork& network);

// Regions made from sections alone, as in hulls, wings and bottles.

/// Lines of a region through sections, in the given order: the first and the last are outlines, the
/// others inner lines.
///
/// Closed sections form an annulus. Open sections may run in either direction. They get two rails,
/// "rail 1" and "rail 2": splines through their starts and their ends, with not-a-knot end
/// conditions. Start: the end that is nearer to the start of the section before. Throws InputError
/// if there are fewer than two sections, if open and closed ones are mixed, or if neighbours share
/// an end point. Cost: O(sections).
std::vector<CharacterLine> section_lines(std::vector<CharacterLine> sections);

/// True if all sections are closed and have a corner of more than `corner_angle` degrees at their
/// seam, as aerofoils at the trailing edge.
bool have_corner_at_seam(const std::vector<CharacterLine>& sections, double corner_angle);

/// Rails of closed sections with a corner: "rail 1" through the corners, "rail 2" through the
/// points farthest from them, in this order. With the rails, the sections bound two surfaces in
/// each bay. Throws InputError if there are fewer than two sections. Cost: O(sections).
std::vector<CharacterLine> corner_rails(const std::vector<CharacterLine>& sections);

/// Lays out the region of section_lines(), for loft_shape().
///
/// For open sections it has four corners, where rails meet the first and the last section (at 2° or
/// more), and a polygonal domain. `options.edge_length` 0: 1/33 of the size. Throws as
/// section_lines() and RegionLayout.
RegionLayout section_region(const std::string& name, std::vector<CharacterLine> sections,
                            SkinOptions options, const Progress& progress = {});

}  // namespace batten
