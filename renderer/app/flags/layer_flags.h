// The flags of further layers of EXR files.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/flags/flag_set.h"
#include "renderer/app/options/options.h"
#include "renderer/base/result.h"
#include "renderer/film/aov.h"

namespace kindling::app {

// Adds --aov and --cryptomatte, which insert into `aovs`.
void add_layer_flags(FlagSet& flags, AovSet& aovs);
// Adds --shadow-catcher and --shadow-catchers.
void add_shadow_catcher_flags(FlagSet& flags, RenderOptions& o);
// Makes the background transparent with shadow catchers. Fails (usage) if another one is given.
[[nodiscard]] Result<void> check_layer_flags(const FlagSet& flags, RenderOptions& o);
// The same as add_layer_flags() for `kindling info`, whose help is shorter.
void add_layer_estimate_flags(FlagSet& flags, AovSet& aovs);

} // namespace kindling::app
