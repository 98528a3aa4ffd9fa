// Members of Document that need the complete type of its JSON tree.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/document/document.h"

#include <nlohmann/json.hpp>

namespace kindling::gltf {

Document::Document() = default;
Document::Document(Document&&) noexcept = default;
Document& Document::operator=(Document&&) noexcept = default;
Document::~Document() = default;

} // namespace kindling::gltf
