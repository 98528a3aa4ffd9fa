// Builds a kd-tree of moving planes over triangles that deform, for one slice of the shutter.
//
// A plane goes along a straight line through the slice, with the mean velocity of the triangles near it. At any one time the tree is a
// plain kd-tree: a node's planes divide all of space, and a triangle is in each leaf whose cell it touches then; a leaf has those that
// touch it at any time of the slice. So a mesh that moves as a whole takes no more references than one that stands still. The idea is that of
// hierarchies whose boxes are interpolated over time (Hou, Qin, Li, Guo, Zhou, "Micropolygon ray tracing with defocus and motion
// blur", 2010; Gruenschloss, Stich, Nawaz, Keller, "MSBVH", 2011), carried over to planes. Where triangles near each other move in
// different ways, slices of the shutter help, as in 4-D kd-trees (Olsson, "Ray tracing time-continuous animations using 4D
// kD-trees", 2007): see slices.h.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/build.h"
#include "accel/kdtree/deforming/swept.h"

#include <span>

namespace kindling::accel::kd {

struct MovingTree {
  BinaryTree binary; // bounds are those of the whole slice; BinaryNode::way moves its planes
  double cost = 0.0; // expected of a ray at any time of the slice, times the half area of the bounds at its middle
};

// Costs are those at the middle of the slice. Progress counts as `weight` triangles. Same tree for any number of threads.
[[nodiscard]] MovingTree build_moving_tree(const Config& config, std::span<const Geometry> geometries,
                                           std::span<const LeafReference> triangles, const TimeSlice& slice,
                                           double weight, BuildMonitor& monitor);

} // namespace kindling::accel::kd
