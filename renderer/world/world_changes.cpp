// Builds and rebuilds the accelerator of a World, and exchanges its environment.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/world/world_changes.h"

#include "accel/make_accelerator.h"
#include "renderer/world/builtin_environment.h"

#include <cassert>
#include <utility>

namespace kindling {

bool WorldChanges::build_accelerator(World& world, const WorldOptions& options,
                                     std::unique_ptr<accel::PersistentStructures> structures, const CancelToken* cancel,
                                     ProgressListener* listener) {
  accel::BuildOptions build_options;
  build_options.quality = options.quality;
  build_options.robust = options.robust;
  build_options.simd = options.simd;
  if (cancel) build_options.cancel = &cancel->cancel_flag();
  build_options.on_progress = [&](double fraction) {
    if (listener) listener->on_progress({.phase = Phase::build, .done = fraction, .total = 1.0});
  };
  if (cancel && cancel->cancelled()) return false;
  world.hides_backs = options.hide_backs;
  world.view_point = options.view_point;
  world.filters_hits = false;
  for (size_t i = 0; i < world.accel_meshes_.size(); ++i) { // the hit filter leaves backs out
    const bool filtered = options.hide_backs && world.is_single_sided(world.materials[world.geometries[i].material]);
    world.accel_meshes_[i].opaque = world.covers[i] != 0 && !filtered;
    world.filters_hits |= !world.accel_meshes_[i].opaque;
  }
  world.accelerator_ =
      accel::make_accelerator(options.accelerator, world.accelerator_input(), build_options, std::move(structures));
  if (!world.accelerator_) return false;
  world.probed = world.accelerator_.get();
  if (options.wrap_accelerator) world.accelerator_ = options.wrap_accelerator(std::move(world.accelerator_));
  world.traced = world.accelerator_.get();
  return true;
}

Result<void> WorldChanges::hide_backs(World& world, const WorldOptions& options, const CancelToken* cancel,
                                      ProgressListener* listener) {
  world.view_point = options.view_point;
  if (world.hides_backs == options.hide_backs) return {};
  std::unique_ptr<accel::PersistentStructures> structures = world.accelerator_->take_structures();
  world.accelerator_ = nullptr;
  if (!build_accelerator(world, options, std::move(structures), cancel, listener))
    return Error{ErrorKind::render_failed, "cancelled while the accelerator was built"};
  world.statistics_.accelerator = world.accelerator_->statistics();
  return {};
}

void WorldChanges::light_by_studio(World& world, bool studio) {
  assert(world.lit_by_emission_alone_);
  if (studio == world.lights.has_environment) return;
  world.light_set_->set_environment(studio ? builtin_environment() : nullptr);
  world.lights = *world.light_set_;
  world.statistics_.light_bytes = world.light_set_->memory_bytes();
}

} // namespace kindling
