// Writes a CalculiX (ccx) input deck for the natural frequencies of a shell mesh.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "batten/mesh/shell_mesh.h"

namespace batten {

/// A shell with uniform thickness and material. The units are up to the user but must be
/// consistent: with mm, N and MPa, the density is in t/mm³ (steel: 7.85e-9) and frequencies are in
/// Hz.
struct ModalDeck {
  /// Element types for linear faces. Second-order faces always become S6 and S8R.
  enum class Elements {
    Quadratic,  ///< S6 and S8R, with nodes added at the edge midpoints
    /// S3 and S4: two to ten times faster. S4 needs a mesh twice as fine for the same accuracy; S3
    /// is two to four times too stiff and only suitable for a first estimate.
    Linear
  };

  double thickness = 0, young = 0, poisson = 0, density = 0;
  int count = 10;            ///< number of elastic modes, in addition to rigid-body modes
  std::vector<int> clamped;  ///< nodes without displacement and rotation; empty: a free part
  Elements elements = Elements::Quadratic;
  std::string units;  ///< units, for a comment in the deck: "mm, N, MPa, t, s"
};

/// Writes `path` (.inp) for `ccx -i <path without .inp>` or scripts/ccx_frequencies. The file is
/// written atomically.
///
/// Node and element numbers are those of the mesh + 1. Added nodes follow them; they are clamped if
/// both ends of their edge are. Quads with a repeated node become triangles. Faces with fewer than
/// three different corners, and unused nodes, are left out. An unsupported part has six rigid-body
/// modes of frequency 0 for each connected component. The deck requests these in addition and
/// states their number in its line "** Rigid-body modes: 6".
///
/// The first six frequencies of a clamped square plate with width / thickness = 100 exceed those of
/// plate theory by:
///
///            10 × 10 squares   20 × 20 squares
///     S8R    2.2 to 2.7 %      1 %
///     S6     5 to 11 %         1.3 to 1.8 %
///     S4     14 to 38 %        1 to 2.4 %
///     S3     230 to 290 %      94 to 137 %
///
/// Errors for a free plate: S8R 0.4 %, S6 1 %, S4 7 % (10 × 10) and 0.5 % (20 × 20).
///
/// Throws InputError: thickness, Young's modulus, density or count not above 0, Poisson's ratio not
/// in (-1, 0.5), no faces, faces with more than four corners, non-finite coordinates, node indices
/// out of range, a file that cannot be written.
void write_modal_deck(const std::filesystem::path& path, const ShellMesh& mesh,
                      const ModalDeck& modes);

}  // namespace batten
