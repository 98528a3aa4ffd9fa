// The flags of the Whitted tracer, with its three named configurations.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/flags/flag_set.h"
#include "renderer/app/options/options.h"
#include "renderer/base/result.h"

namespace kindling::app {

void add_whitted_flags(FlagSet& flags, RenderOptions& options);
// Applies the configuration that --tracer names, except for flags that were given. Fails (usage) on
// flags of this tracer that are given to another integrator.
[[nodiscard]] Result<void> apply_whitted_flags(const FlagSet& flags, RenderOptions& options);

} // namespace kindling::app
