// The files of the page, which the build embeds from renderer/view/page.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string_view>

namespace kindling {

struct PageFile {
  std::string_view name; // "view.css"
  std::string_view content_type;
  std::string_view text;
};

[[nodiscard]] std::span<const PageFile> page_files();

} // namespace kindling
