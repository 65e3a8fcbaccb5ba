// Curves that are sections of one shape, one behind the other, with nothing between them.
#pragma once

#include <vector>

#include "batten/skinning/network/curve_network.h"

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

}  // namespace batten
