// Compiles tinygltf, and lends it a JSON tree where it would parse text.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/json/tinygltf_core.h"

#include <nlohmann/json.hpp>

#include <cstdint>
#include <cstring>
#include <exception>

// TinyGLTF::LoadFromString() takes text, parses it into a local tree with JsonParse(), and reads
// the root's extras from that tree at the very end. The overloads here match the arguments of these
// two calls better than tinygltf's own functions do: the first moves the lent tree into the local
// one, the second moves it back. The text is a Loan. Other versions of tinygltf (2.9, in Debian 13)
// call their own functions by qualified names: the loan is then no valid JSON and not taken, and
// read_tree() hands over the tree as text.
namespace {

struct Loan {
  char not_json[8] = {'t', 'r', 'e', 'e', ' ', 'a', 't', ' '};
  nlohmann::json* tree = nullptr;
  bool* taken = nullptr;
};

[[maybe_unused]] void JsonParse(nlohmann::json& local, const char* text, unsigned int, bool) {
  Loan loan;
  std::memcpy(&loan, text, sizeof(loan));
  *loan.taken = true;
  local = std::move(*loan.tree);
  local["extras"] = reinterpret_cast<std::uintptr_t>(loan.tree);
}

} // namespace

namespace kindling_tinygltf {

[[maybe_unused]] static bool ParseExtrasProperty(Value*, nlohmann::json& local) {
  nlohmann::json& extras = local["extras"];
  auto* tree = reinterpret_cast<nlohmann::json*>(extras.get<std::uintptr_t>());
  extras = nullptr;
  *tree = std::move(local);
  return true;
}

} // namespace kindling_tinygltf

#define TINYGLTF_IMPLEMENTATION
#define TINYGLTF_NO_INCLUDE_JSON
#define tinygltf kindling_tinygltf
#include <tiny_gltf.h>
#undef tinygltf

namespace kindling::gltf {

std::string read_tree(nlohmann::json& tree, tinygltf::Model& model) {
  const bool has_extras = tree.contains("extras");
  nlohmann::json extras = has_extras ? std::move(tree["extras"]) : nlohmann::json();
  bool taken = false;
  const Loan loan{.tree = &tree, .taken = &taken};
  tinygltf::TinyGLTF parser;
  std::string error;
  std::string ignored;
  try {
    bool read =
        parser.LoadASCIIFromString(&model, &error, &ignored, reinterpret_cast<const char*>(&loan), sizeof(loan), "");
    if (!taken) {
      error.clear();
      const std::string text = tree.dump();
      read = parser.LoadASCIIFromString(&model, &error, &ignored, text.data(), static_cast<unsigned>(text.size()), "");
    }
    if (!read || !tree.is_object()) return error.empty() ? "unknown error" : error;
  } catch (const std::exception& e) {
    return e.what();
  }
  if (has_extras) {
    tree["extras"] = std::move(extras);
  } else {
    tree.erase("extras");
  }
  return {};
}

} // namespace kindling::gltf
