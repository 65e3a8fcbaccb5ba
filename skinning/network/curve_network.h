// SPDX-License-Identifier: MPL-2.0
// Builds a network of edges and nodes from unordered input curves (character lines).
#pragma once

#include <string>
#include <vector>

#include "batten/core/progress.h"
#include "batten/skinning/lines/character_line.h"
#include "batten/skinning/network/network_edge.h"

namespace batten {

/// Tolerances and angles for CurveNetwork.
struct NetworkOptions {
  /// Gap tolerance, model units: ends and curves closer than this are joined. 0: automatic, that is
  /// 1e-3 of the network size, or more for imprecise input such as sketches.
  ///
  /// The automatic tolerance is raised if fewer than half of the curve ends and crossings are
  /// joined within 1e-3 of the size. It is then derived from the gaps between curve ends and the
  /// nearest other curve. Only gaps up to 2e-2 of the size count, and at least half of all ends
  /// must have such a gap. An end that overshoots a crossing by less than 2e-2 of the size counts
  /// as joined to the curve that it crosses. The tolerance becomes 1.4 times the largest gap if
  /// that is at most twice the 80th percentile of the gaps, otherwise 1.4 times that percentile.
  /// The tolerance never exceeds 2e-2 of the size.
  double tolerance = 0;
  /// Largest allowed distance between an input curve and the C1 cubic curves of the edges made from
  /// it, model units, if the input curve was not repaired. 0: 1e-4 of the network size.
  double fit_tolerance = 0;
  /// Corner angle, degrees, from 0 to 180: a curve is split where its tangent turns by more than
  /// this angle.
  double corner_angle = 20;
  /// Tangent angle, degrees, from 0 to 180: an edge continues another edge at a node if the angle
  /// between their tangents there is at most this angle. The two edges then get a common tangent.
  /// Edges of one smooth curve always continue each other. Each edge end has at most one
  /// continuation: the edge with the smallest angle.
  double tangent_angle = 20;
};

/// A network of smooth edges between nodes, made from unordered input curves: curves are joined
/// where their ends meet other ends or the interior of other curves, and split where they cross.
///
/// The result is canonical: it depends only on the geometry of the curves. Edges and nodes are
/// ordered, and edges are oriented, by their position; edges are named after their curves. Shuffled
/// input gives bit-identical networks; reversed curves give the same network up to rounding. A
/// closed smooth curve without any contact gets one node, at its farthest point along a fixed
/// direction.
///
/// Repairs: a curve is displaced by at most the tolerance. Ends are moved to their common node, and
/// the displacement fades out along the edge. The node lies at the mean of the joined ends or, if
/// an end meets the interior or a corner of a curve, on that curve. The rotation to a common
/// tangent adds a displacement of at most half the tolerance. A node joins only ends within the
/// tolerance, nearest first; ends that are slightly farther away are reported as near misses.
/// Curves that stay close to each other over less than 3 √(tolerance · size) are tangent, not
/// overlapping, unless they coincide. NetworkDiagnostic describes which problems are repaired and
/// which are only reported.
class CurveNetwork {
 public:
  /// Builds the network.
  ///
  /// Throws InputError for: no curves; duplicate names; a curve without geometry or of zero length;
  /// points that are not finite; a tolerance below 0 or above a tenth of the network size; angles
  /// outside 0 to 180 degrees; curves drawn over each other many times; no curve longer than the
  /// tolerance. Cost: about O(n log n) for n curves of bounded length.
  explicit CurveNetwork(const std::vector<CharacterLine>& lines, const NetworkOptions& options = {},
                        const Progress& progress = {});

  /// The input curves, as passed to the constructor.
  const std::vector<CharacterLine>& lines() const { return lines_; }
  const std::vector<NetworkEdge>& edges() const { return edges_; }
  const std::vector<NetworkNode>& nodes() const { return nodes_; }
  const std::vector<NetworkDiagnostic>& diagnostics() const { return diagnostics_; }
  /// Diagonal of the bounding box of all curves, model units.
  double size() const { return size_; }
  /// Gap tolerance of the network, model units: NetworkOptions::tolerance or the automatic value.
  double tolerance() const { return tolerance_; }
  /// Fraction of the curve ends whose distance from another curve is at most 1e-3 of the network
  /// size, from 0 to 1.
  ///
  /// If this fraction is below 0.5, the result counts crossings of curves as joined ends. The
  /// result is 1 if NetworkOptions::tolerance is above 0. If the result is below 0.5, the automatic
  /// tolerance() may be larger than 1e-3 of the size (see NetworkOptions::tolerance).
  double joined_fraction() const { return joined_fraction_; }
  /// Indices of the edges of the input curve called `name`, in order along the curve, or the index
  /// of the edge called `name`. Throws InputError if there is neither such a curve nor such an
  /// edge; the message contains the most similar name.
  std::vector<int> edges_of(const std::string& name) const;
  /// Unit tangent of an edge at one of its ends. It points from the node into the edge.
  Vec3 direction(const EdgeEnd& end) const;

 private:
  std::vector<CharacterLine> lines_;
  std::vector<NetworkEdge> edges_;
  std::vector<NetworkNode> nodes_;
  std::vector<NetworkDiagnostic> diagnostics_;
  std::vector<std::vector<int>> edges_of_line_;
  double size_ = 1, tolerance_ = 0, joined_fraction_ = 1;
};

/// CurveNetwork::joined_fraction() of curves, without their network. Throws InputError for invalid
/// curves and options. Cost: about O(n log n) for n curves of bounded length.
double joined_fraction(const std::vector<CharacterLine>& lines, const NetworkOptions& options = {});

}  // namespace batten
