// Whether a mesh can be afforded, and a tolerance reached.
#pragma once

#include <string>

namespace batten {

/// Bytes that skinning takes at its highest for a mesh of so many triangles: mostly its factor,
/// which grows as n log n.
double bytes_for_triangles(double triangles);

/// Throws InputError for a mesh that is too large: of more than two million triangles, or for which
/// there is not enough memory (available_memory). The message says how much it would take, and which
/// edge_length needs half of what there is. `what`: "a region", "a ring"; `edge_length`, `size` in model
/// units.
void require_mesh_size(double triangles, double edge_length, double size, const std::string& what);

/// The same for all regions of a model together: at least 2 kB a triangle. What the factor of
/// regions in one shape takes is asked for when it is planned (SparseCholesky).
void require_model_size(double triangles, double edge_length, double size);

inline constexpr double kMaxTriangles = 2e6;

/// Returns how many triangles a region may have after those under its embedded lines were halved:
/// 50,000, or ten times those of its size and edge length, (size/edge)².
double max_refined_triangles(double edge_length, double size);

/// Throws InputError for a tolerance of lines below 1e-9 of the size: shapes are not computed more
/// exactly.
void require_tolerance(double tolerance, double size);

}  // namespace batten
