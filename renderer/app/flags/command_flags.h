// Declares the flags of each command and checks their combinations.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/options/options.h"
#include "renderer/base/result.h"

namespace kindling::app {

class FlagSet;
// Declare the flags of a command. Parsing fills `options`, which must outlive the set and have its
// default values before: the help prints them.
void add_render_flags(FlagSet& flags, RenderOptions& options);
void add_info_flags(FlagSet& flags, InfoOptions& options);
void add_shootout_flags(FlagSet& flags, ShootoutOptions& options);
void add_merge_flags(FlagSet& flags, MergeOptions& options);
void add_denoise_flags(FlagSet& flags, DenoiseOptions& options);
void add_relight_flags(FlagSet& flags, RelightOptions& options);
void add_scaling_flags(FlagSet& flags, ScalingOptions& options);
void add_view_flags(FlagSet& flags, LiveOptions& options);
// Check combinations of flags and fill in defaults that depend on several; fail (usage).
[[nodiscard]] Result<void> check_render_flags(const FlagSet& flags, RenderOptions& options);
[[nodiscard]] Result<void> check_info_flags(const FlagSet& flags, const InfoOptions& options);
[[nodiscard]] Result<void> check_shootout_flags(const FlagSet& flags, ShootoutOptions& options);
[[nodiscard]] Result<void> check_scaling_flags(const FlagSet& flags, ScalingOptions& options);
[[nodiscard]] Result<void> check_denoise_flags(const FlagSet& flags, const DenoiseOptions& options);
[[nodiscard]] Result<void> check_relight_flags(const FlagSet& flags, RelightOptions& options);
[[nodiscard]] Result<void> check_view_flags(const FlagSet& flags, LiveOptions& options);
[[nodiscard]] Result<void> check_merge_flags(const FlagSet& flags, const MergeOptions& options);

} // namespace kindling::app
