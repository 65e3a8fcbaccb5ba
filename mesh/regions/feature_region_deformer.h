// SPDX-License-Identifier: MPL-2.0
// Restoration of the shape of feature regions in the result of any deformer [Hu2012].
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "batten/mesh/deform/deform_problem.h"
#include "batten/mesh/triangle_mesh.h"

namespace batten {

// Feature regions: parts of a mesh that keep their shape in an edit.

/// A feature region (part of a mesh that keeps its shape), given by triangles or by vertices.
struct FeatureRegion {
  std::string name;
  /// Triangle indices; if empty, the triangles with at least one corner in `vertices`.
  std::vector<int> faces;
  std::vector<int> vertices;          ///< vertex indices; ignored unless `faces` is empty
  std::optional<Mat3> rotation = {};  ///< prescribed rotation; empty: fitted to the estimated shape
  double scale = 1;                   ///< scale factor of the region, above 0
};

/// Options of FeatureRegionDeformer.
struct FeatureRegionOptions {
  enum class Kind {
    /// Regions keep their shape approximately, by a penalty term.
    Soft,
    /// Regions keep their shape exactly. The rotation of each region follows from the estimate (see
    /// FeatureRegionDeformer), so that only its translation is unknown in the linear system.
    Hard
  } kind = Kind::Hard;
  enum class Rhs {
    Estimate,  ///< Laplacian vectors of the estimated shape, which the surface keeps
    Original   ///< Laplacian vectors of the undeformed mesh [Hu2012], which resist large bending
  } rhs = Rhs::Estimate;
  enum class Mean {
    Squared,  ///< the region rotation is the mean_rotation() of its faces' rotations
    Robust    ///< the region rotation is the median_rotation() of its faces' rotations [Hu2012]
  } mean = Mean::Squared;
  double weight = 2e7;  ///< weight of the penalty term of soft regions, dimensionless
};

/// Connected components (along mesh edges) of the vertices whose `mask` is nonzero. The vertices of
/// each component are ascending; the components are sorted by their lowest-numbered vertices.
/// Throws InputError if the size of the mask differs from the number of vertices. O(edges).
std::vector<std::vector<int>> components_of_mask(const TriangleMesh& mesh,
                                                 const std::vector<char>& mask);

/// The triangles of a feature region, ascending. Throws InputError if an index is out of range or
/// the region has no triangles; the message names the region.
std::vector<int> faces_of(const TriangleMesh& mesh, const FeatureRegion& region);

/// Deformation that keeps feature regions rigid [Hu2012]. An estimate V' of the deformed vertex
/// positions (p'_i at vertex i), from any deformer, determines the rotation of each region. The
/// positions p are computed again with rigid regions:
///
///     min ½ Σ_i A_i |L(p_i) - l_i|²                                                  (5)
///       + ½ weight/size² Σ_regions Σ_f A_f Σ_e |e - s R e⁰|² / Σ_e |e⁰|²             (6), soft
///     L(p_i) = (L_c p)_i / (2 A_i),   l_i = L(p'_i) of the estimate, or L(p_i⁰)
///
/// Fixed vertices and handles are satisfied exactly. The cotangent Laplacian L_c and the mixed
/// areas A_i are defined in mesh/differential_operators.h. A_f is the area of a face f, e are its
/// edges, s is the scale of its region, p⁰ and e⁰ are undeformed values, and size is the mesh size.
/// The rotation R in (6) is R', one per region: the mean of the rotations R_f of the faces of the
/// region from the undeformed mesh to V' (see rotation_of_face(); [Hu2012], eq. 11). For hard
/// regions, (6) is replaced by the constraints p_i - p_r = s R' (p_i⁰ - p_r⁰) for all vertices i of
/// the region, where r is a reference vertex of the region.
///
/// R' is the first that applies: the prescribed rotation of the region; the rotation of a handle
/// that shares vertices with the region; no rotation if the region has a fixed vertex; the mean of
/// the R_f. A handle that shares vertices with the region also determines s. Hard regions that
/// share vertices have a common rotation: the one prescribed for any of them, or the mean over the
/// faces of all of them.
///
/// One Cholesky factorization serves any number of edits, rotations and scales. An edit costs one
/// solve for x, y and z, and the computation of the rotations.
class FeatureRegionDeformer {
 public:
  /// Sets up and factors the linear system. `fixed`, `handles`: vertices as in DeformProblem.
  /// Throws InputError if faces_of() or check() (deform_problem.h) does, a name is missing or
  /// repeated, a prescribed rotation is not a rotation matrix to 1e-9, or a scale or weight is not
  /// above 0. Throws NoSolutionError if the factorization fails.
  FeatureRegionDeformer(const TriangleMesh& mesh, std::vector<FeatureRegion> regions,
                        std::vector<int> fixed, std::vector<Handle> handles,
                        const FeatureRegionOptions& options = {});
  ~FeatureRegionDeformer();
  FeatureRegionDeformer(FeatureRegionDeformer&&) noexcept;
  FeatureRegionDeformer& operator=(FeatureRegionDeformer&&) noexcept;

  /// Computes the deformed positions of all vertices. `moves`: one transformation per handle.
  /// `estimate`: vertex positions (n×3) that any deformer computed for the same moves. Throws
  /// InputError if the moves are invalid, the number of points is wrong or a value is not finite,
  /// and ConflictError if hard regions or constraints require different positions of a common
  /// vertex.
  const Points& deform(const Points& estimate, std::span<const HandleTransform> moves);
  /// Computes preliminary positions of all vertices, in which each face of a region has its own
  /// rotation instead of that of the region, so that regions bend as in the estimate. For
  /// Kind::Hard, the first call factors an additional system with soft regions. Parameters and
  /// exceptions are those of deform().
  const Points& deform_per_face(const Points& estimate, std::span<const HandleTransform> moves);

  /// Prescribes the rotation of a region; empty: the rotation is fitted to the estimated shape. No
  /// new factorization is needed.
  void set_rotation(int region, const std::optional<Mat3>& rotation);
  /// Sets the scale factor of a region, above 0. No new factorization is needed.
  void set_scale(int region, double scale);

  const Points& positions() const;
  /// Rotation of each feature region in the last call of deform().
  const std::vector<Mat3>& region_rotations() const;
  /// Scale factor of each feature region in the last call of deform().
  const std::vector<double>& region_scales() const;
  /// Rotation of each face of a region from the undeformed mesh to the last estimate, in the order
  /// of faces().
  const std::vector<Mat3>& face_rotations(int region) const;
  /// Triangle indices of a feature region, ascending.
  const std::vector<int>& faces(int region) const;
  /// Indices of all vertices of the triangles of a feature region.
  const std::vector<int>& vertices(int region) const;
  const std::vector<FeatureRegion>& regions() const;
  /// Number of free unknowns of the linear system per coordinate.
  int unknowns() const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace batten
