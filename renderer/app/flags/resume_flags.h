// The flags of `kindling resume`.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/options/resume_options.h"
#include "renderer/base/result.h"

namespace kindling::app {

class FlagSet;

void add_resume_flags(FlagSet& flags, ResumeOptions& options);
[[nodiscard]] Result<void> check_resume_flags(const FlagSet& flags, const ResumeOptions& options);

} // namespace kindling::app
