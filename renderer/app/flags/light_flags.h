// The flags of the scene's lights: their sizes, paths and groups.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/session/image_settings.h"

namespace kindling::app {

class FlagSet;

void add_light_flags(FlagSet& flags, LightOptions& options);
void add_direct_samples_flag(FlagSet& flags, ImageSettings& settings);
void add_reflection_samples_flag(FlagSet& flags, ImageSettings& settings);
void add_path_reuse_flag(FlagSet& flags, ImageSettings& settings);
void add_light_paths_flag(FlagSet& flags, ImageSettings& settings);
void add_photons_flag(FlagSet& flags, ImageSettings& options);
void add_environment_filter_flag(FlagSet& flags, IntegratorSettings& settings);
void add_manifold_samples_flag(FlagSet& flags, IntegratorSettings& settings);
void add_light_groups_flag(FlagSet& flags, IntegratorSettings& settings);

} // namespace kindling::app
