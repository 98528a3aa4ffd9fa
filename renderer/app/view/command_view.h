// Runs `kindling view`.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/options/options.h"
#include "renderer/app/terminal/console.h"
#include "renderer/base/result.h"

namespace kindling::app {

// Loads the scene, prints a link to the page, and serves it until a signal comes. Returns the exit
// code of the signal. Fails as ViewSession::open() and HttpServer::bind() do.
[[nodiscard]] Result<int> run_view(const LiveOptions& options, Console& console);

} // namespace kindling::app
