// SPDX-License-Identifier: MPL-2.0
// Lofts: detects curves that are sections of one shape, and makes faces from sections alone.
#pragma once

#include <string>
#include <vector>

#include "batten/core/progress.h"
#include "batten/skinning/layout/region_layout.h"
#include "batten/skinning/network/curve_network.h"

namespace batten {

/// The order of sections along a loft: a chain of nearest neighbours. `sections`: points on each
/// section, uniform along it; all sections are closed (first point not repeated) or all are open.
///
/// Consecutive sections must face each other. Closed sections, and open ones whose ends nearly
/// meet: their planes differ by at most 60° and do not coincide, and their centres are displaced
/// sideways by at most the larger mean radius or twice their distance along the normal (swept
/// wings). Other open sections: chords differ by at most 45° and lie side by side. The result is
/// empty if they do not. Cost: O(n³).
std::vector<int> loft_order(const std::vector<std::vector<Vec3>>& sections, bool closed);

/// Orders the curves of a network along a loft by loft_order(), if all of them are sections: no
/// curve meets another one, and either
///
///     all are closed and smooth, three or more: circles of a bottle, frames of a hull, a pipe;
///     all are open, two or more: stations, ribs.
///
/// The result is empty for other curves, and if the sections do not face each other. Two closed
/// smooth curves are the boundary circles of an annulus (find_regions()); closed sections with
/// corners: find_loft(). Cost: O(n³) for n curves.
std::vector<CharacterLine> ordered_sections(const CurveNetwork& network);

// Faces made from sections alone, as in hulls, wings and bottles.

/// Computes the curves of a face through sections, in the given order. The first and the last
/// section are outlines; the others are inner curves.
///
/// Closed sections form an annulus. Open sections may run in either direction. Two rails are added:
/// "rail 1" through the starts of the sections and "rail 2" through their ends, as cubic splines
/// with not-a-knot end conditions. Each open section is directed so that its ends are closest to
/// those of the previous section. Throws InputError if there are fewer than two sections, if some
/// sections are open and others closed, or if consecutive open sections share an end point. Cost:
/// O(sections).
std::vector<CharacterLine> section_lines(std::vector<CharacterLine> sections);

/// True if `curve` is the name of a rail from section_lines(), such as "rail 1", or the name of a
/// part of a rail, such as "rail 1.2".
bool is_rail(const std::string& curve);

/// A rail: the cubic spline through points with chord-length parametrisation and not-a-knot end
/// conditions; straight between two points.
CharacterLine rail_through(const std::string& name, const std::vector<Vec3>& points);

/// Builds the layout (domain, mesh and curves) of a face through sections, as input of
/// loft_shape(). The curves of the face are those of section_lines().
///
/// A face through open sections has four corners, at which the rails meet the first and the last
/// section. The corner angle is at most 2° and the default domain is polygonal.
///
/// `name`: name of the face. `options.edge_length`: model units; 0: 1/33 of the diagonal of the
/// sections' bounding box. `options.sections` is always set to true. Throws as section_lines() and
/// RegionLayout do. Cost: that of the constructor of RegionLayout.
RegionLayout section_region(const std::string& name, std::vector<CharacterLine> sections,
                            SkinOptions options, const Progress& progress = {});

}  // namespace batten
