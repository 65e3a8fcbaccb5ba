// Restores the shape of feature regions in the result of any deformer [Hu2012].
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

/// A feature region, given by triangles or by vertices.
struct FeatureRegion {
  std::string name;
  /// Triangle indices; if empty, the triangles with at least one corner in `vertices`.
  std::vector<int> faces;
  std::vector<int> vertices;          ///< vertex indices; ignored if `faces` is not empty
  std::optional<Mat3> rotation = {};  ///< rotation set by the user; none: fitted to the estimate
  double scale = 1;                   ///< scale of the region, above 0
};

/// How FeatureRegionDeformer keeps feature regions. Equation numbers refer to that class.
struct FeatureRegionOptions {
  enum class Kind {
    Soft,  ///< rows (6) with `weight`: regions keep their shape approximately and join softly
    Hard   ///< p = s R' p⁰ + t holds exactly and is eliminated: three unknowns per region
  } kind = Kind::Hard;
  enum class Rhs {
    Estimate,  ///< L V', the Laplacian vectors of the estimate
    Original   ///< L V, as in the paper: they do not rotate and resist large bends
  } rhs = Rhs::Estimate;
  enum class Mean {
    Squared,  ///< mean_rotation: min Σ A_f ‖R' - R_f‖²
    Robust    ///< median_rotation: min Σ A_f ‖R' - R_f‖, equation (10)
  } mean = Mean::Squared;
  double weight = 2e7;  ///< weight of soft regions in (6), dimensionless
};

/// Connected components (along edges) of the vertices whose mask is not 0. Each is ascending; they
/// are sorted by their lowest vertices. Throws InputError if the size of the mask differs from the
/// vertex count. O(mesh).
std::vector<std::vector<int>> components_of_mask(const TriangleMesh& mesh,
                                                 const std::vector<char>& mask);

/// The triangles of a region, ascending. Throws InputError, naming the region: indices out of
/// range, or no triangles.
std::vector<int> faces_of(const TriangleMesh& mesh, const FeatureRegion& region);

/// Deformation that keeps feature regions rigid [Hu2012]. An estimate V' of the deformed mesh, from
/// any deformer, determines the rotation of each region. The mesh is then solved for again with
/// every region kept rigid:
///
///     min ½ Σ_i A_i |L(p_i) - l_i|²                                                  (5)
///       + ½ weight/size² Σ_regions Σ_f A_f Σ_e |e - s R e⁰|² / Σ_e |e⁰|²             (6), soft
///     L(p_i) = (L_c p)_i / (2 A_i),   l_i = L(p'_i) of the estimate, or L(p_i⁰)
///
/// Fixed vertices and handles are satisfied exactly. L_c, A_i: see mesh/differential_operators.h.
/// A_f is the area of a face, e its edges, size the size of the mesh. R is R', one rotation per
/// region (11): the mean over its faces of the rotations R_f from the mesh to V' (see
/// rotation_of_face()). For hard regions, (6) is replaced by p_i - p_r = s R' (p_i⁰ - p_r⁰) for all
/// vertices of the faces of the region.
///
/// R' is taken from the first of these sources: the user; a constraint on a vertex of the region (a
/// fixed vertex: no rotation; a handle: its rotation, and its scale for s); the estimate. Hard
/// regions that share vertices rotate together: with the rotation that the user set for any of
/// them, or with the mean over all their faces.
///
/// One Cholesky factorization serves any number of edits, rotations and scales. An edit costs one
/// solve for x, y and z, and the fitting of rotations.
class FeatureRegionDeformer {
 public:
  /// Throws InputError (see faces_of() and check() in deform_problem.h; missing or repeated names;
  /// a matrix that is not a rotation to 1e-9; a scale or weight not above 0) or NoSolutionError
  /// (the factorization fails).
  FeatureRegionDeformer(const TriangleMesh& mesh, std::vector<FeatureRegion> regions,
                        std::vector<int> fixed, std::vector<Handle> handles,
                        const FeatureRegionOptions& options = {});
  ~FeatureRegionDeformer();
  FeatureRegionDeformer(FeatureRegionDeformer&&) noexcept;
  FeatureRegionDeformer& operator=(FeatureRegionDeformer&&) noexcept;

  /// Computes the final positions of all vertices. `estimate`: n×3, from any deformer with the same
  /// moves. `moves`: one per handle. Throws InputError (moves; a wrong number of points or values
  /// that are not finite) or ConflictError (hard regions whose common vertices or constraints
  /// require different positions).
  const Points& deform(const Points& estimate, std::span<const HandleTransform> moves);
  /// Computes the preliminary result: (6) with the individual R_f of each face, which bends regions
  /// like the estimate. For Kind::Hard the first call builds a soft system with its own
  /// factorization.
  const Points& deform_per_face(const Points& estimate, std::span<const HandleTransform> moves);

  /// Sets the rotation of a region, or none to fit it to the estimate. Does not refactor.
  void set_rotation(int region, const std::optional<Mat3>& rotation);
  /// Sets the scale of a region, above 0. Does not refactor.
  void set_scale(int region, double scale);

  const Points& positions() const;
  /// R' of each region in the last deform().
  const std::vector<Mat3>& region_rotations() const;
  /// Scale s of each region in the last deform().
  const std::vector<double>& region_scales() const;
  /// R_f of the faces of a region, in the order of faces().
  const std::vector<Mat3>& face_rotations(int region) const;
  /// Triangles of a region, ascending.
  const std::vector<int>& faces(int region) const;
  /// All corners of the faces of a region: the vertices that a hard region keeps.
  const std::vector<int>& vertices(int region) const;
  const std::vector<FeatureRegion>& regions() const;
  /// Number of free unknowns per coordinate.
  int unknowns() const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace batten
