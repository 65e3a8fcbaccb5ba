// SPDX-License-Identifier: MPL-2.0
// Conforming quadratic elements of a whole model: faces that share a curve share its nodes.
//
// Two faces share a curve if one curve of each (mesh-aligned or embedded) has the same name. It is
// then the same curve in space, whatever its direction and parametrisation in each face. A point
// on it is identified by its fraction f of the parameter range,
//
//      f = (t - t0) / (t1 - t0)   along the curve of the first face.
//
// Edges on a curve end at the same fractions in all adjacent faces. These are the vertices of the
// faces in which it is mesh-aligned or, if there are none, the subdivision of the first face. If a
// face needs more points (because curves meet there, or triangles would fold), the other faces get
// the same points: faces are meshed again until no face needs more points. Edge midpoints are at
// the middle of the parameter interval, and therefore shared as well.
//
// Nodes are not merged by distance, with one exception: ends of curves that are closer than 1e-6 of
// the model size become one node.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "batten/skinning/facets/facets.h"

namespace batten {

/// Quadratic elements of all faces, and global node numbers: faces that meet at a curve share its
/// nodes.
struct ModelElements {
  /// Elements of each face, with node numbers that are local to the face.
  std::vector<QuadraticElements> regions;
  /// For each face, the request with which it was meshed. facets() for the same `edge_length` and
  /// request gives facets that conform across faces.
  std::vector<SubdivisionRequest> requests;
  /// For each face and each node of this face: the number of the node in the model, starting at 0,
  /// in the order of first occurrence.
  std::vector<std::vector<int>> node;
  /// Position of each node of the model. If several faces share the node, its position is that in
  /// the first face in which the shared curve is mesh-aligned, so that the node is exactly on the
  /// curve. If all these faces have the curve embedded, the node is on the curve of the first face.
  std::vector<Vec3> positions;
  struct Line {
    std::string name;
    /// Node numbers in the model for each element edge on this curve: first end, second end,
    /// midpoint. An edge that several faces share is listed once.
    std::vector<std::array<int, 3>> edges;
  };
  std::vector<Line> lines;  ///< one entry per curve name, in the order of first occurrence
};

/// Computes conforming quadratic elements of a model. A model of one face has the elements and node
/// numbers of this face.
///
/// `regions`: one or more faces, not null, in the order of ModelElements::regions. `edge_length`:
/// target length of edges on embedded curves, model units; 0: facet_length() of each face.
///
/// Cost: that of quadratic_elements() for each face if all shared curves are mesh-aligned;
/// otherwise faces with embedded curves are meshed about twice.
///
/// Throws InputError if `regions` is empty; if curves of the same name differ by more than 1e-2 of
/// the size of the smaller face; if no common subdivision of two adjacent faces is found; or if two
/// nodes of an element become one node. Also throws as quadratic_elements() does.
ModelElements model_elements(const std::vector<const SkinnedRegion*>& regions,
                             double edge_length = 0);

}  // namespace batten
