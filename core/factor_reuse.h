// How often a factor will be used.
#pragma once

namespace batten {

/// What the effort for a good order of the unknowns is measured against.
///
/// One factor: AMD. Many factorizations of one pattern, or thousands of solves: from 10,000
/// unknowns on METIS is tried beside AMD and the factor with fewer entries is kept. Measured on
/// sheets, METIS costs ten times AMD's analysis; at 100,000 unknowns it saves a quarter of every
/// factorization and a sixth of every solve and has paid after 10 factorizations or 400 solves,
/// at 14,000 unknowns after 40 or 800, below that hardly ever. An order that the caller knows from
/// the geometry (nested_dissection_order) costs next to nothing and is as good. Eigen's factor has AMD
/// only.
enum class FactorReuse { once, many };

}  // namespace batten
