// SPDX-License-Identifier: MPL-2.0
// Files of the derivatives of an edited mesh.
#pragma once

#include <filesystem>
#include <vector>

#include "batten/io/meshes/mesh_file.h"
#include "batten/scenes/meshes/morph_derivatives.h"
#include "batten/scenes/runs/run_support.h"

namespace batten {

/// What the files contain.
struct DerivativeTable {
  const DeformScene* scene;
  const MeshFile* file;
  const Points* points;  ///< edited positions of all vertices, n×3
  const std::vector<MeshDimension>* dimensions;
  const std::vector<MorphDerivative>* derivatives;  ///< without missing ones
  std::vector<ParameterSweep> ranges;               ///< bounds of DESVAR cards
};

/// Checks the extension: .csv, .npz; .bdf .nas .dat .fem for a Nastran deck only. Throws InputError.
void require_derivative_format(const std::filesystem::path& path, const MeshFile& file);

/// Writes derivatives of all nodes; the extension selects the format.
///
///     .csv            one row a node: number, position, three columns a parameter: "EDIT.HANDLE.x:dx"
///     .npz            NumPy arrays: parameters (p texts), values (p), nodes (n numbers), points
///                     (n×3), derivatives (p×n×3), dimensions (d texts), dimension_values (d),
///                     dimension_derivatives (d×p)
///     .bdf .nas …     Nastran bulk data in large fields: a DESVAR card a parameter, with the ranges
///                     as bounds, and a DVGRID card for each node that moves, in the basic
///                     coordinate system with the coefficient 1
///
/// Throws FileError.
void write_derivatives(const std::filesystem::path& path, const DerivativeTable& table);

/// A cell of a CSV file, in quotation marks where it needs them.
std::string csv_cell(const std::string& text);

}  // namespace batten
