// Builds a kd-tree of moving planes over deforming triangles, for one slice of the shutter.
//
// A plane moves along a straight line through the slice, with the mean velocity of the triangles
// near it. At any one time the tree is a plain kd-tree: its planes divide all of space, and a
// triangle is in each leaf whose cell it touches at that time; a leaf contains those that touch it
// at any time of the slice. So a mesh that moves as a whole needs no more references than a static
// one. The finished tree has the boxes of what is in the cells, with faces that move along straight
// lines too (Hou, Qin, Li, Guo, Zhou, "Micropolygon ray tracing with defocus and motion blur",
// 2010; Gruenschloss, Stich, Nawaz, Keller, "MSBVH", 2011). Where neighboring triangles move
// differently, slices of the shutter help, as in 4-D kd-trees (Olsson, "Ray tracing time-continuous
// animations using 4D kD-trees", 2007): see slices.h.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/build/build.h"
#include "accel/kdtree/deforming/swept.h"

#include <span>

namespace kindling::accel::kd {

struct MovingTree {
  BinaryTree binary;      // bounds of the whole slice
  Imath::Box3f bounds[2]; // at begin and end; bounds at other times are interpolated
  double cost = 0.0; // expected cost of a ray at any time of the slice, times the half area of the bounds at its middle
};

// Builds the tree of one slice, with costs at its middle. Progress counts as `weight` triangles.
// The tree is the same for any number of threads.
[[nodiscard]] MovingTree build_moving_tree(const Config& config, std::span<const Geometry> geometries,
                                           std::span<const LeafReference> triangles, const TimeSlice& slice,
                                           double weight, BuildMonitor& monitor);

} // namespace kindling::accel::kd
