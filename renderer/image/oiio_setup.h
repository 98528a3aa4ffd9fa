// The process-wide settings of OpenImageIO, made once before its first use here.
// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace kindling::image_detail {

// One thread for each conversion (pictures are decoded in parallel by the caller). Thread-safe, idempotent.
void prepare_oiio();

} // namespace kindling::image_detail
