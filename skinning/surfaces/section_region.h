// Curves that are sections of one shape, one behind the other, with nothing between them.
#pragma once

#include <vector>
#include <string>

#include "batten/skinning/network/curve_network.h"
#include "batten/core/progress.h"
#include "batten/skinning/layout/region_layout.h"

namespace batten {

/// The lines of a network in their order along a loft, where all of them are sections: no line meets
/// another one, and either
///
///     all are closed and smooth, three or more: circles of a bottle, frames of a hull, a pipe;
///     all are closed with a corner where they begin, two or more: airfoils;
///     all are open, two or more: stations, ribs.
///
/// The order is a chain of nearest neighbours. Each section has to face the next one: planes of
/// closed ones differ by 60 degrees at most and are not one plane, chords of open ones differ by 45
/// degrees at most and lie beside each other. Otherwise there is no row, and the result is empty.
/// Two closed curves are the rims of a ring (find_regions()). O(n²) for n lines.
std::vector<CharacterLine> ordered_sections(const CurveNetwork& network);


// Regions from sections alone, as hulls, wings and bottles are drawn.

/// The lines of a region that runs through sections in this order: the first and the last are its
/// outline, those between them inner lines. Closed sections make a ring. Open ones, which may run
/// in either direction, get two rails, "rail 1" and "rail 2": the splines through their starts and
/// through their ends (start: the end that is nearer to the start of the section before), whose own
/// ends are not flat (open_spline.h).
///
/// Throws InputError: fewer than two sections, open and closed ones, neighbours that begin or end
/// at one place. O(sections).
std::vector<CharacterLine> section_lines(std::vector<CharacterLine> sections);

/// Whether closed sections have a corner where they begin and end, as airfoils at their trailing edge:
/// all of them turn there by more than `corner_angle` degrees.
bool have_corner_at_seam(const std::vector<CharacterLine>& sections, double corner_angle);

/// The rails of closed sections with a corner, in this order: "rail 1" through their corners, "rail 2"
/// through the points that are farthest from these. With them the sections bound two surfaces in each
/// bay. Throws InputError: fewer than two sections. O(sections).
std::vector<CharacterLine> corner_rails(const std::vector<CharacterLine>& sections);

/// The region of these lines. Of open sections it has four corners, where rails leave the first
/// and the last section, at two degrees or more, and a polygon for its domain. `options.edge_length`
/// 0: 1/33 of the size. For loft_shape(). Throws as section_lines() and RegionLayout.
RegionLayout section_region(const std::string& name, std::vector<CharacterLine> sections,
                            SkinOptions options, const Progress& progress = {});

}  // namespace batten
