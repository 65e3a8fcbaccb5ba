// Writes shell elements as an input deck of CalculiX (ccx) for natural frequencies.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "batten/mesh/shell_mesh.h"

namespace batten {

/// A vibrating shell of one thickness and material. The user chooses the units, which must fit
/// together: mm, N and MPa need t/mm³ (steel: 7.85e-9) and give Hz.
struct ModalDeck {
  /// The elements that linear faces become. Second-order faces always become S6 and S8R.
  enum class Elements {
    Quadratic,  ///< S6 and S8R: nodes are added half-way between corners
    Linear      ///< S3 and S4: two to ten times as fast. S4 needs twice as fine a mesh to be as
                ///< good; S3 is two to four times too stiff and only good for a first look
  };

  double thickness = 0, young = 0, poisson = 0, density = 0;
  int count = 10;            ///< number of elastic modes; rigid motions are found besides them
  std::vector<int> clamped;  ///< nodes without displacement and rotation; none: the part is free
  Elements elements = Elements::Quadratic;
  std::string units;  ///< units as a comment in the deck: "mm, N, MPa, t, s"
};

/// Writes `path` (.inp) for `ccx -i <path without .inp>` or scripts/ccx_frequencies. The file
/// appears whole or not at all.
///
/// Node and element numbers are those of the mesh + 1; added nodes come behind (they are clamped
/// where both ends of their edge are). Quads with a node twice become triangles; faces with fewer
/// than three different corners and nodes of no face are left out. A part that is held nowhere has
/// six modes of frequency 0 (six for each of its pieces): the deck asks for them too and says in
/// its line "** Rigid motions: 6" how many there are.
///
/// The first six frequencies of a clamped square plate, 100 times as wide as thick, are higher than
/// those of plate theory by:
///
///            10 × 10 squares   20 × 20 squares
///     S8R    2.2 to 2.7 %      1 %
///     S6     5 to 11 %         1.3 to 1.8 %
///     S4     14 to 38 %        1 to 2.4 %
///     S3     230 to 290 %      94 to 137 %
///
/// Errors of a free plate: S8R 0.4 %, S6 1 %, S4 7 % (10 × 10) and 0.5 % (20 × 20).
///
/// Throws InputError: thickness, Young's modulus, density or count not above 0, Poisson's ratio not
/// in (-1, 0.5), no faces, faces of more than four corners, coordinates that are not finite,
/// numbers of nodes out of range, a file that cannot be written.
void write_modal_deck(const std::filesystem::path& path, const ShellMesh& mesh,
                      const ModalDeck& modes);

}  // namespace batten
