// All that kernels read of a scene: views whose arrays are in the memory of a device.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/view.h"
#include "renderer/camera/camera.h"
#include "renderer/guiding/bright_patches.h"
#include "renderer/guiding/light_selection_tree.h"
#include "renderer/guiding/volume_guide.h"
#include "renderer/integrator/manifolds/manifold_view.h"
#include "renderer/integrator/stages/first_hit.h"
#include "renderer/integrator/stages/light_path_stages.h"
#include "renderer/integrator/stages/path_stages.h"
#include "renderer/integrator/whitted_shader.h"
#include "renderer/sampling/pixel_filter.h"
#include "renderer/sampling/sampler.h"
#include "renderer/world/light_groups/light_groups_view.h"
#include "renderer/world/world_view.h"

namespace kindling {

// Pointers among its members are addresses in the device's memory.
struct DeviceScene {
  accel::kd::StructureView tree;
  WorldView world; // has `tree` in place of an accelerator
  CameraView camera;
  BrightPatches patches;
  LightSelectionTreeView light_probabilities;
  VolumeGuideView volumes;
  EnvironmentGuideView to_environment;
  CausticGuideView caustics;
  PresampledEnvironmentView presampled;
  ManifoldView manifolds;
  LightPathStages light_paths; // if stages.light_paths is set
  PathStages stages;           // of the path tracer
  WhittedShader shader;        // of the Whitted tracer
  LightGroupsView groups;      // of waves that split light
  FirstHitStages first_hit;    // of ambient occlusion and the debug views
  Sampler sampler;
  PixelFilter filter;
};

} // namespace kindling
