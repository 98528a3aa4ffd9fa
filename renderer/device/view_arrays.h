// The arrays of each view, for functions that copy them.
//
// for_each_array(view, f) calls f(span) for every array; f may set the span to a copy. An array of
// views is one array: those of its elements are not visited.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/view.h"
#include "renderer/camera/camera.h"
#include "renderer/guiding/caustic_guide.h"
#include "renderer/guiding/environment_guide.h"
#include "renderer/guiding/light_selection_tree.h"
#include "renderer/guiding/volume_guide.h"
#include "renderer/integrator/manifolds/manifold_view.h"
#include "renderer/integrator/stages/light_path_view.h"
#include "renderer/light/light_set_view.h"
#include "renderer/light/per_light_sampling.h"
#include "renderer/texture/procedural_texture.h"
#include "renderer/texture/texture.h"
#include "renderer/world/light_groups/light_groups_view.h"
#include "renderer/world/world_view.h"

#include <cstddef>
#include <span>

namespace kindling {

template <class F>
void for_each_array(GeometryView& geometry, F&& f) {
  f(geometry.positions);
  f(geometry.indices);
  f(geometry.attributes);
  f(geometry.later_positions);
  f(geometry.later_frames);
}

// The texels must be in memory, not in pages. Levels in tiles have none.
template <class F>
void for_each_array(TextureView& texture, F&& f) {
  for (TextureView::Level& level : texture.levels) {
    const auto texels = static_cast<size_t>(level.width) * static_cast<size_t>(level.height);
    std::span<const std::byte> bytes(level.pixels, level.pixels == nullptr ? 0 : texels * texture.pixel_bytes);
    f(bytes);
    level.pixels = bytes.data();
  }
}

template <class F>
void for_each_array(ProceduralTextureView& texture, F&& f) {
  f(texture.program.instructions);
  f(texture.program.constants);
  f(texture.program.footprints);
  f(texture.program.frequencies);
  f(texture.streams);
}

template <class F>
void for_each_array(LightProfileView& profile, F&& f) {
  f(profile.vertical_deg);
  f(profile.horizontal_deg);
  f(profile.candela);
}

template <class F>
void for_each_array(EnvironmentView& environment, F&& f) {
  f(environment.texels);
  f(environment.distribution.rows.cdf);
  f(environment.distribution.rows.guide);
  f(environment.distribution.cdfs);
  f(environment.distribution.guides);
  f(environment.row_factors);
  f(environment.levels.texels);
}

template <class F>
void for_each_array(PresampledEnvironmentView& presampled, F&& f) {
  f(presampled.entries);
}

template <class F>
void for_each_array(ManifoldView& manifolds, F&& f) {
  f(manifolds.targets);
  f(manifolds.lamps);
}

template <class F>
void for_each_array(LightGroupsView& groups, F&& f) {
  f(groups.of_emitter);
  f(groups.of_node);
  f(groups.of_material);
  f(groups.nodes.of_mesh);
  f(groups.nodes.of_instance);
}

// Emission::texture refers to an element of WorldView::textures and is not followed.
template <class F>
void for_each_array(LightSetView& lights, F&& f) {
  f(lights.emissions);
  f(lights.triangles);
  f(lights.uvs);
  f(lights.moving);
  f(lights.later_corners);
  f(lights.punctuals);
  f(lights.profiles);
  f(lights.frames);
  f(lights.spheres.spheres);
  f(lights.spheres.nodes);
  f(lights.disks);
  f(lights.tree.nodes);
  f(lights.tree.emitters);
  f(lights.tree.places);
  for_each_array(lights.environment, f);
}

template <class F>
void for_each_array(WorldView& world, F&& f) {
  f(world.textures);
  for_each_array(world.lights, f);
  f(world.geometries);
  f(world.materials);
  f(world.layer_materials);
  f(world.media);
  f(world.procedurals.textures);
  f(world.procedurals.images);
  f(world.procedurals.instances);
  f(world.instances);
  f(world.motions);
  f(world.first_emissive);
  f(world.covers);
  f(world.opacity.first);
  f(world.opacity.entries);
  f(world.opacity.words);
  f(world.contacts.table);
  f(world.contacts.rows);
}

// PerLightView::lights is not followed.
template <class F>
void for_each_array(PerLightView& lights, F&& f) {
  f(lights.entries);
  f(lights.sums);
}

// EmissionView::lights is not followed.
template <class F>
void for_each_array(LightPathView& light_paths, F&& f) {
  f(light_paths.emission.targets);
  f(light_paths.emission.cdf);
  f(light_paths.casters);
}

template <class F>
void for_each_array(CameraView& camera, F&& f) {
  f(camera.keys);
}

template <class F>
void for_each_array(LightSelectionTreeView& tree, F&& f) {
  f(tree.nodes);
  f(tree.probabilities);
}

template <class F>
void for_each_array(VolumeGuideView& guide, F&& f) {
  f(guide.nodes);
  f(guide.regions);
  f(guide.quarters);
}

template <class F>
void for_each_array(EnvironmentGuideView& guide, F&& f) {
  f(guide.nodes);
  f(guide.shares);
}

template <class F>
void for_each_array(CausticGuideView& guide, F&& f) {
  f(guide.nodes);
  f(guide.regions);
}

} // namespace kindling
