// Feature regions that keep their shape in the result of any deformer.
#pragma once

#include <memory>
#include <span>
#include <vector>
#include <optional>
#include <string>

#include "batten/mesh/deform/deform_problem.h"
#include "batten/mesh/triangle_mesh.h"

namespace batten {

// Regions of a mesh whose shape should survive an edit.

struct FeatureRegion {
  std::string name;
  std::vector<int> faces;     ///< triangles; none: those with at least one corner in `vertices`
  std::vector<int> vertices;  ///< not looked at when there are faces
  std::optional<Mat3> rotation = {};  ///< the user's, instead of the estimate's mean
  double scale = 1;                   ///< above 0
};

/// How FeatureRegionDeformer keeps them; (5), (6), (10): its equations.
struct FeatureRegionOptions {
  enum class Kind {
    Soft,  ///< rows (6) with `weight`: regions keep their shape nearly, and join softly
    Hard   ///< p = s R' p⁰ + t exactly, eliminated: three unknowns a region
  } kind = Kind::Hard;
  enum class Rhs {
    Estimate,  ///< L V', the Laplacian vectors of the estimate
    Original   ///< L V, as the paper has it: they do not turn, and resist large bends
  } rhs = Rhs::Estimate;
  enum class Mean {
    Squared,  ///< mean_rotation: min Σ A_f ‖R' - R_f‖²
    Robust    ///< median_rotation: min Σ A_f ‖R' - R_f‖, equation (10)
  } mean = Mean::Squared;
  double weight = 2e7;  ///< Soft: see below; without unit
};

/// The connected components (along edges) of the vertices whose mask is not 0, each ascending,
/// sorted by their lowest vertices. Throws InputError when the mask has another size than the mesh.
/// O(mesh).
std::vector<std::vector<int>> components_of_mask(const TriangleMesh& mesh,
                                                 const std::vector<char>& mask);

/// The triangles of a region, ascending. Throws InputError that names the region: numbers out of
/// range, nothing in it.
std::vector<int> faces_of(const TriangleMesh& mesh, const FeatureRegion& region);


/// Hu, Song, Cao: an estimate V' of the deformed mesh, from any deformer, tells how each region has
/// turned; the mesh is then solved for once more with every region kept rigid:
///
///     min ½ Σ_i A_i |L(p_i) - l_i|²                                                  (5)
///       + ½ weight/size² Σ_regions Σ_f A_f Σ_e |e - s R e⁰|² / Σ_e |e⁰|²             (6), soft
///     L(p_i) = (L_c p)_i / (2 A_i),   l_i = L(p'_i) of the estimate, or L(p_i⁰)
///
/// with fixed vertices and handles exact. L_c, A_i: mesh/differential_operators.h; A_f: area of a face, e its
/// edges, size the mesh's. R is R', one rotation a region (11): the mean over its faces of the
/// rotations R_f (rotation_of_face) from the mesh to V'. Hard: instead of (6) all vertices of the
/// region's faces are p_i - p_r = s R' (p_i⁰ - p_r⁰).
///
/// R' comes, in this order: from the user; from what holds a vertex of the region (a fixed one: no
/// turn; a handle: its turn, and its scale for s); from the estimate. Hard regions that share
/// vertices turn as one: the user's rotation of any of them, or the mean over all their faces.
///
/// One Cholesky factor for any number of edits, rotations and scales; an edit is one solve for x, y
/// and z, and the rotations. Source: Hu, Song, Cao, Mesh editing with feature region preservation.
class FeatureRegionDeformer {
 public:
  /// Throws InputError (faces_of(), check() in deform_problem.h; names missing or twice; a rotation
  /// that is none to 1e-9; a scale or weight not above 0), NoSolutionError (no factor).
  FeatureRegionDeformer(const TriangleMesh& mesh, std::vector<FeatureRegion> regions,
                        std::vector<int> fixed, std::vector<Handle> handles,
                        const FeatureRegionOptions& options = {});
  ~FeatureRegionDeformer();
  FeatureRegionDeformer(FeatureRegionDeformer&&) noexcept;
  FeatureRegionDeformer& operator=(FeatureRegionDeformer&&) noexcept;

  /// All vertices: the final result. `estimate`: n×3, of any deformer, with the same moves. Throws
  /// InputError (moves; another number of points, or not finite), ConflictError (hard regions that
  /// what they share or what holds them would have two ways at once).
  const Points& deform(const Points& estimate, std::span<const HandleTransform> moves);
  /// The rough result: (6) with each face's own R_f, which bends regions as the estimate did. Of a
  /// deformer of the kind Hard the first call makes a soft one, with a factor of its own.
  const Points& deform_per_face(const Points& estimate, std::span<const HandleTransform> moves);

  /// The user's rotation of a region, or none; its scale. No new factor.
  void set_rotation(int region, const std::optional<Mat3>& rotation);
  void set_scale(int region, double scale);

  const Points& positions() const;
  /// R' and s of each region in the last deform(); R_f of the faces of a region in the order of
  /// faces().
  const std::vector<Mat3>& region_rotations() const;
  const std::vector<double>& region_scales() const;
  const std::vector<Mat3>& face_rotations(int region) const;
  const std::vector<int>& faces(int region) const;
  /// All corners of the region's faces: what a hard region keeps.
  const std::vector<int>& vertices(int region) const;
  const std::vector<FeatureRegion>& regions() const;
  /// Free unknowns of one coordinate.
  int unknowns() const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace batten
