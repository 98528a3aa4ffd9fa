// The flags of the Whitted tracer, and the three named tracers.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/flags/flag_set.h"
#include "renderer/app/options/options.h"
#include "renderer/base/result.h"

namespace kindling::app {

void add_whitted_flags(FlagSet& flags, RenderOptions& options);
// Fills in what a named tracer (--tracer) stands for, but for flags that were given themselves. Fails (usage) on flags that mean nothing
// to the integrator.
[[nodiscard]] Result<void> apply_whitted_flags(const FlagSet& flags, RenderOptions& options);

} // namespace kindling::app
