// Writes skinned regions as an input deck of CalculiX (ccx) with shell elements.
#pragma once

#include <filesystem>
#include <vector>

#include "batten/io/decks/shell_deck.h"
#include "batten/skinning/region/skinned_region.h"

namespace batten {

/// Writes `path` (.inp) for `ccx -i <path without .inp>`. The file appears whole or not at all.
///
/// Each element becomes one S6 triangle (or its parts, of other types) of its vertices and the
/// surface's points at the parametric midpoints of its edges. The surface is the middle surface;
/// normals are x_u × x_v of each region.
/// In a deck of one region, node numbers are mesh vertex + 1, then vertex_count + edge + 1; element
/// numbers are triangle + 1. The elements of a region with embedded lines are its quadratic_elements:
/// the deck is the region inside of its boundary, with nodes on its lines.
///
/// Several regions are one shell (model_elements()). They share the nodes on a line that they share,
/// which lie where a region that has the line as a run has them; where lines meet there is one
/// node. Nodes and elements are numbered region after region, a shared node where it first comes.
/// Where regions meet at a crease, ccx joins the thick elements of both sides rigidly. Loads act on
/// all regions.
///
/// The deck has the node set NALL, the element set ALL, one node set for each line of the model
/// (also for rims of holes and ribs) and, with several regions, one element set for each. Their
/// names are in capitals, with '_' for all but letters and digits, and a number behind where two
/// would be the same. Area and line forces become nodal loads, by the quadratic shape functions on
/// the true surface. Supports in boxes have node sets SUPPORT_1, …. Numbers have the 20 characters that ccx reads: their relative error is 1e-13 at most.
///
/// Throws InputError: no region, thickness, Young's modulus not above 0, Poisson's ratio not in
/// (-1, 0.5), a density below 0 or gravity without density, numbers that are not finite, no
/// support, one that holds no node, a line or region that the model does not have (with the nearest name), what
/// model_elements() throws, a file that cannot be written.
void write_calculix(const std::filesystem::path& path,
                    const std::vector<const SkinnedRegion*>& regions, const ShellDeck& deck);

}  // namespace batten
