// Formatting of error messages, and the collection of warnings by kind.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/files/failure.h"

#include <fmt/format.h>

#include <algorithm>

namespace kindling::gltf {
namespace {

constexpr size_t kMaxKinds = 100;

} // namespace

std::string place_message(std::string_view pointer, std::string_view message, std::string_view code) {
  std::string text;
  if (!pointer.empty()) text.append(pointer).append(": ");
  text.append(message);
  if (!code.empty()) text.append(" (").append(code).append(")");
  return text;
}

std::string_view code_of(const ImportFailure& failure) {
  const std::string_view message = failure.error.message;
  const size_t open = message.rfind(" (");
  if (open == std::string_view::npos || !message.ends_with(')')) return {};
  return message.substr(open + 2, message.size() - open - 3);
}

void fail(std::string_view pointer, std::string_view message, std::string_view code, ErrorKind kind) {
  throw ImportFailure{{kind, place_message(pointer, message, code)}};
}

std::string in_quotes(std::string_view text) {
  constexpr size_t kLongest = 80;
  std::string out = "'";
  for (const char c : text.substr(0, kLongest)) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x20 || byte == 0x7f) {
      out += fmt::format("\\x{:02x}", byte);
    } else {
      out += c;
    }
  }
  if (text.size() > kLongest) {
    // Do not cut a UTF-8 sequence.
    while (!out.empty() && (static_cast<unsigned char>(out.back()) & 0xc0U) == 0x80U) out.pop_back();
    if (!out.empty() && static_cast<unsigned char>(out.back()) >= 0xc0U) out.pop_back();
    out += "...";
  }
  out += '\'';
  return out;
}

void Warnings::add(Entry entry) {
  const auto found =
      std::find_if(entries_.begin(), entries_.end(), [&](const Entry& e) { return e.kind == entry.kind; });
  if (found != entries_.end()) {
    found->count += entry.count;
  } else if (entries_.size() < kMaxKinds) {
    entries_.push_back(std::move(entry));
  } else {
    left_out_ += entry.count;
  }
}

void Warnings::add(std::string_view kind, std::string_view pointer, std::string_view message, std::string_view code) {
  add({std::string(kind), place_message(pointer, message, code), 1});
}

void Warnings::repair(std::string_view kind, const ImportFailure& fault, std::string_view remedy) {
  if (strict_) throw fault;
  add({std::string(kind), fmt::format("{}; {}", fault.error.message, remedy), 1});
}

void Warnings::repair(std::string_view kind, std::string_view pointer, std::string_view message, std::string_view code,
                      std::string_view remedy) {
  repair(kind, ImportFailure{{ErrorKind::scene_invalid, place_message(pointer, message, code)}}, remedy);
}

void Warnings::append(const Warnings& other) {
  for (const Entry& entry : other.entries_) add(entry);
  left_out_ += other.left_out_;
}

void Warnings::send(std::string_view file, ProgressListener* listener) const {
  if (listener == nullptr) return;
  for (const Entry& entry : entries_) {
    std::string text = fmt::format("{}: {}", file, entry.message);
    if (entry.count > 1) text += fmt::format(" [and {} more like it]", entry.count - 1);
    listener->on_warning(text);
  }
  if (left_out_ > 0) listener->on_warning(fmt::format("{}: and {} other warnings", file, left_out_));
}

} // namespace kindling::gltf
