// The flags of further layers of EXR files.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/flags/flag_set.h"
#include "renderer/film/aov.h"

namespace kindling::app {

// Adds --aov and --cryptomatte, which insert into `aovs`.
void add_layer_flags(FlagSet& flags, AovSet& aovs);
// The same for `kindling info`, whose help is shorter.
void add_layer_estimate_flags(FlagSet& flags, AovSet& aovs);

} // namespace kindling::app
