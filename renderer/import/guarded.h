// Turns the exceptions of the importer into errors of one line.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"
#include "renderer/import/files/failure.h"

#include <exception>
#include <filesystem>
#include <new>
#include <string>
#include <system_error>

namespace kindling::gltf {

// Returns what `work` returns.
template <typename Value, typename Work>
Result<Value> guarded(const std::filesystem::path& path, const Work& work) {
  const auto error = [&](ErrorKind kind, const std::string& message) {
    return Error{kind, path.string() + ": " + message};
  };
  try {
    return work();
  } catch (const ImportFailure& failure) {
    return error(failure.error.kind, failure.error.message);
  } catch (const std::bad_alloc&) {
    return error(ErrorKind::render_failed, "not enough memory to read the scene");
  } catch (const std::system_error& e) { // of the machine: threads, files
    return error(ErrorKind::input_output, std::string("cannot be read: ") + e.what());
  } catch (const std::exception& e) {
    return error(ErrorKind::scene_invalid, std::string("cannot be read: ") + e.what());
  }
}

} // namespace kindling::gltf
