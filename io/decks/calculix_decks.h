// SPDX-License-Identifier: MPL-2.0
// Writes CalculiX (ccx) input decks: linear static shell problems, buckling and frequencies of models,
// and the natural frequencies of shell meshes.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "batten/io/decks/shell_deck.h"
#include "batten/mesh/shell_mesh.h"
#include "batten/skinning/region/skinned_region.h"

namespace batten {

// Models.

/// Writes a linear shell analysis of faces of a model as a CalculiX deck `path` (.inp). Run
/// it with `ccx -i <path without .inp>`. The file is written atomically.
///
/// Each triangle of the surface mesh becomes one S6 element, or is split into S3 or S8R elements.
/// The nodes are the vertices and the surface points at the parametric midpoints of the edges. The
/// surface is the mid-surface of the shell; shell normals have the direction of x_u × x_v. In a
/// deck with one face, node numbers are mesh vertex + 1, then vertex_count + edge + 1; element
/// numbers are triangle + 1. A face with embedded curves is meshed by quadratic_elements(), which
/// cover the face inside its boundary and have nodes on the embedded curves.
///
/// Several faces form one shell (model_elements()). They share the nodes on their common curves.
/// The positions of these nodes are taken from a face whose mesh is aligned with the curve. Curves
/// that meet at a point share one node. Nodes and elements are numbered face by face; a shared node
/// is numbered with the first face that contains it. At a crease, ccx connects the thick elements
/// of both sides rigidly. Loads act on all faces.
///
/// The deck has the node set NALL, the element set ALL, and one node set for each curve of the
/// model (including boundaries of holes, and ribs). With several faces it also has one element set
/// per face. Names of sets are written in capitals, with '_' in place of every character other than
/// letters and digits. A name that does not begin with a letter gets the prefix CURVE_ or FACE_;
/// numbers are appended to make names unique. Area and line forces become consistent nodal loads,
/// integrated over the exact surface with quadratic shape functions. Supports in boxes get the node
/// sets SUPPORT_1, SUPPORT_2, …, and nodes with conditions along other directions than x, y and z a
/// local coordinate system (*TRANSFORM). Springs are SPRINGA elements to fixed nodes. Plies become
/// a section COMPOSITE, with the orientation of each element. Numbers are written with 20 characters, the most that ccx reads, so
/// their relative error is at most 1e-13.
///
/// Throws InputError if there is no face; a thickness or Young's modulus is not above 0; Poisson's
/// ratio is not in (-1, 0.5); the density is below 0, or 0 with gravity; a number is not finite;
/// there is no support, or a support without nodes; a curve or face is unknown (the message
/// suggests the most similar name); model_elements() fails; or the file cannot be written.
void write_calculix(const std::filesystem::path& path,
                    const std::vector<const SkinnedRegion*>& regions, const ShellDeck& deck);

// Natural frequencies.

/// A shell with uniform thickness and material. Any consistent system of units can be used: with
/// mm, N and MPa, the density is in t/mm³ (steel: 7.85e-9) and frequencies are in Hz.
struct ModalDeck {
  /// Element type for faces of first order. Faces of second order always become S6 and S8R
  /// elements.
  enum class Elements {
    Quadratic,  ///< S6 and S8R elements, with nodes added at the edge midpoints
    /// S3 and S4 elements, which are two to ten times faster than quadratic elements. S4 needs a
    /// mesh twice as fine for the same accuracy. S3 is two to four times too stiff and suitable for
    /// first estimates only.
    Linear
  };

  double thickness = 0, young = 0, poisson = 0, density = 0;
  int count = 10;  ///< number of elastic modes to compute, in addition to rigid-body modes
  std::vector<int> clamped;  ///< clamped nodes (no displacement, no rotation); empty: unsupported
  Elements elements = Elements::Quadratic;
  std::string units;  ///< names of the units for a comment in the deck: "mm, N, MPa, t, s"
};

/// Writes a CalculiX deck `path` (.inp) that computes the natural frequencies of a shell mesh. Run
/// it with `ccx -i <path without .inp>` or scripts/ccx_frequencies. The file is written atomically.
///
/// Node and element numbers are the indices in the mesh + 1. Added midpoint nodes get the following
/// numbers; they are clamped if both ends of their edge are clamped. Quads with a repeated node
/// become triangles. Faces with fewer than three different corners and unused nodes are omitted.
/// Each connected component without clamped nodes has six rigid-body modes of frequency 0. The deck
/// requests these modes in addition to `count` and contains their number in the line "** Rigid-body
/// modes: 6".
///
/// The first six frequencies of a clamped square plate (width / thickness = 100) exceed the
/// frequencies of plate theory by the following amounts:
///
///            10 × 10 squares   20 × 20 squares
///     S8R    2.2 to 2.7 %      1 %
///     S6     5 to 11 %         1.3 to 1.8 %
///     S4     14 to 38 %        1 to 2.4 %
///     S3     230 to 290 %      94 to 137 %
///
/// For a free plate, the errors are 0.4 % with S8R, 1 % with S6, and with S4 7 % (10 × 10 squares)
/// or 0.5 % (20 × 20 squares).
///
/// Throws InputError if the thickness, Young's modulus, density or count is not above 0; Poisson's
/// ratio is not in (-1, 0.5); there are no faces, or a face has more than four corners; a
/// coordinate is not finite; a node index is out of range; or the file cannot be written.
void write_modal_deck(const std::filesystem::path& path, const ShellMesh& mesh,
                      const ModalDeck& modes);

}  // namespace batten
