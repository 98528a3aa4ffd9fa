// Finds the statements of a PTX text, their symbols, and what they refer to.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/device/cuda/ptx_modules.h"

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <cstdlib>
#include <map>
#include <vector>

namespace kindling {
namespace {

// A declaration or definition at the top level, with its white space and comments.
struct Statement {
  std::string_view text;
  std::string_view symbol; // empty: a directive that all parts need, as .version
};

bool begins_name(char c) { return std::isalpha(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '$'; }
bool continues_name(char c) { return begins_name(c) || std::isdigit(static_cast<unsigned char>(c)) != 0; }

// Calls visit(name, depth) for each name outside of comments: symbols, labels, parts of directives
// without their dot. `depth` counts open parentheses, brackets and braces. Ends where visit() or
// end(character, depth) returns true; returns the place behind it.
template <typename Visit, typename End>
size_t scan(std::string_view text, size_t at, const Visit& visit, const End& end) {
  int depth = 0;
  while (at < text.size()) {
    const char c = text[at];
    if (text.substr(at, 2) == "//") {
      at = std::min(text.find('\n', at), text.size());
    } else if (text.substr(at, 2) == "/*") {
      at = std::min(text.find("*/", at), text.size() - 2) + 2;
    } else if (continues_name(c) || c == '.' || c == '%') {
      const size_t begin = at++;
      while (at < text.size() && continues_name(text[at])) ++at;
      if (begins_name(c)) visit(text.substr(begin, at - begin), depth);
    } else {
      ++at;
      depth += c == '(' || c == '[' || c == '{' ? 1 : c == ')' || c == ']' || c == '}' ? -1 : 0;
      if (end(c, depth)) return at;
    }
  }
  return at;
}

// The names that LLVM writes at the top level end with ';', bodies of functions with '}'. Lines
// such as ".version 6.0" end with the line.
std::vector<Statement> statements_of(std::string_view ptx) {
  std::vector<Statement> statements;
  size_t at = 0;
  while (at < ptx.size()) {
    const size_t begin = at;
    std::string_view symbol;
    size_t first = ptx.find_first_not_of(" \t\r\n", at);
    while (first < ptx.size() && ptx.substr(first, 2) == "//") // comments before it
      first = ptx.find_first_not_of(" \t\r\n", std::min(ptx.find('\n', first), ptx.size()));
    if (first >= ptx.size()) break;
    const std::string_view rest = ptx.substr(first);
    if (rest.starts_with(".version") || rest.starts_with(".target") || rest.starts_with(".address_size")) {
      at = std::min(ptx.find('\n', first), ptx.size() - 1) + 1;
    } else {
      bool initialized = false; // braces of initial values are no body
      at = scan(
          ptx, first,
          [&](std::string_view name, int depth) {
            if (depth == 0 && symbol.empty()) symbol = name;
          },
          [&](char c, int depth) {
            initialized |= depth == 0 && c == '=';
            return depth == 0 && (c == ';' || (c == '}' && !initialized));
          });
    }
    statements.push_back({ptx.substr(begin, at - begin), symbol});
  }
  return statements;
}

} // namespace

std::string ptx_of_entry(std::string_view ptx, std::string_view entry) {
  const std::vector<Statement> statements = statements_of(ptx);
  std::multimap<std::string_view, size_t> by_symbol; // a declaration and a definition
  for (size_t i = 0; i < statements.size(); ++i)
    if (!statements[i].symbol.empty()) by_symbol.emplace(statements[i].symbol, i);
  if (by_symbol.count(entry) == 0) return {};
  std::vector<bool> needed(statements.size(), false);
  std::vector<size_t> unread;
  const auto need = [&](std::string_view name, int /*depth*/ = 0) {
    const auto [begin, end] = by_symbol.equal_range(name);
    for (auto found = begin; found != end; ++found)
      if (!needed[found->second]) {
        needed[found->second] = true;
        unread.push_back(found->second);
      }
  };
  need(entry);
  while (!unread.empty()) {
    const std::string_view text = statements[unread.back()].text;
    unread.pop_back();
    scan(text, 0, need, [](char, int) { return false; });
  }
  std::string part;
  for (size_t i = 0; i < statements.size(); ++i)
    if (needed[i] || statements[i].symbol.empty()) part += statements[i].text;
  part += '\n';
  return part;
}

unsigned max_registers(std::string_view ptx) {
  constexpr unsigned kOfMultiprocessor = 65536, kOfThread = 255, kUnit = 8;
  const auto number_after = [ptx](std::string_view directive) {
    const size_t at = ptx.find(directive);
    return at == std::string_view::npos
               ? 0U
               : static_cast<unsigned>(std::atoi(std::string(ptx.substr(at + directive.size(), 12)).c_str()));
  };
  const unsigned threads = number_after(".maxntid "), blocks = number_after(".minnctapersm ");
  if (threads * blocks == 0) return kOfThread;
  return std::min(kOfThread, kOfMultiprocessor / (threads * blocks) / kUnit * kUnit);
}

} // namespace kindling
