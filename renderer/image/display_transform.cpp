// Display transform: an OpenColorIO processor, preceded by Khronos PBR Neutral or AgX if selected.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/display_transform.h"

#include "renderer/base/elementary_double.h"
#include "renderer/image/agx.h"
#include "renderer/image/decoders.h"
#include "renderer/image/display_config.h"
#include "renderer/image/pbr_neutral.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <exception>

namespace kindling {

using image_detail::DisplayConfig;
namespace ocio = image_detail::ocio;

namespace {

// From scene-linear Rec. 709 to linear display Rec. 709.
using ToneCurve = Rgb (*)(const Rgb&);

// The curve of a view of the built-in configuration; null: the view is OpenColorIO's alone.
ToneCurve built_in_curve(const std::string& view) {
  if (view == image_detail::kNeutralView) return tone_map_pbr_neutral;
  if (view == image_detail::kAgxView) return tone_map_agx;
  return nullptr;
}

} // namespace

struct DisplayTransform::Impl {
  std::string view;
  std::vector<std::filesystem::path> files;
  ocio::ConstCPUProcessorRcPtr processor; // null for the identity
  ToneCurve curve = nullptr;              // applied before the processor; null for none
  float curve_scale = 1.0f;               // exposure factor, applied before the tone curve
};

namespace {

std::string join(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += fmt::format("{}'{}'", text.empty() ? "" : ", ", name);
  return text;
}

ocio::ConstProcessorRcPtr make_processor(const DisplayConfig& found, const std::string& view, double scale) {
  auto group = ocio::GroupTransform::Create();
  if (scale != 1.0) {
    const double matrix[16] = {scale, 0, 0, 0, 0, scale, 0, 0, 0, 0, scale, 0, 0, 0, 0, 1};
    auto exposure = ocio::MatrixTransform::Create();
    exposure->setMatrix(matrix);
    group->appendTransform(exposure);
  }
  if (found.source_is_aces) group->appendTransform(image_detail::rec709_to_aces2065());
  auto to_display = ocio::DisplayViewTransform::Create();
  to_display->setSrc(found.source.c_str());
  to_display->setDisplay(found.display.c_str());
  to_display->setView(view.c_str());
  group->appendTransform(to_display);
  return found.config->getProcessor(group);
}

// The configuration's own file, then those that the processor was made from.
std::vector<std::filesystem::path> files_of(const DisplayConfig& found, const ocio::Processor& processor) {
  std::vector<std::filesystem::path> files;
  if (found.built_in) return files;
  files.emplace_back(found.name);
  const auto metadata = processor.getProcessorMetadata();
  const auto context = found.config->getCurrentContext();
  for (int i = 0; i < metadata->getNumFiles(); ++i)
    files.emplace_back(context->resolveFileLocation(metadata->getFile(i)));
  return files;
}

} // namespace

DisplayTransform::DisplayTransform(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
DisplayTransform::DisplayTransform(DisplayTransform&&) noexcept = default;
DisplayTransform& DisplayTransform::operator=(DisplayTransform&&) noexcept = default;
DisplayTransform::~DisplayTransform() = default;

Result<DisplayTransform> DisplayTransform::create(const DisplayOptions& options) {
  const Result<DisplayConfig> opened = image_detail::open_display_config(options.ocio_config);
  if (!opened) return opened.error();
  const DisplayConfig& found = opened.value();
  const std::string view = options.view.empty() ? found.views.front() : options.view;
  if (std::find(found.views.begin(), found.views.end(), view) == found.views.end()) {
    return Error{ErrorKind::usage,
                 fmt::format("view '{}' is not in {}; use one of {}", view, found.name, join(found.views))};
  }
  constexpr float kMaxStops = 64.0f;
  if (!(std::abs(options.exposure_stops) <= kMaxStops)) { // also rejects NaN
    return Error{ErrorKind::usage, fmt::format("exposure of {} stops; use -64 to 64", options.exposure_stops)};
  }

  auto impl = std::make_unique<Impl>();
  impl->view = view;
  if (found.built_in) impl->curve = built_in_curve(view);
  const double scale = elementary::exp2(static_cast<double>(options.exposure_stops));
  if (impl->curve != nullptr) impl->curve_scale = static_cast<float>(scale);
  try {
    const auto processor = make_processor(found, view, impl->curve != nullptr ? 1.0 : scale);
    impl->files = files_of(found, *processor);
    if (!processor->isNoOp()) impl->processor = processor->getDefaultCPUProcessor();
  } catch (const std::exception& e) {
    return Error{ErrorKind::input_output,
                 fmt::format("{}: cannot make view '{}': {}", found.name, view, image_detail::first_line(e.what()))};
  }
  return DisplayTransform(std::move(impl));
}

Result<std::vector<std::string>> DisplayTransform::list_views(const std::string& ocio_config) {
  const Result<DisplayConfig> found = image_detail::open_display_config(ocio_config);
  if (!found) return found.error();
  return found.value().views;
}

void DisplayTransform::apply(std::span<float> rgba) const {
  // Pieces are small enough to stay in the cache between the two steps.
  constexpr size_t kPieceValues = size_t{4096} * 4;
  for (size_t first = 0; first < rgba.size(); first += kPieceValues) {
    const std::span<float> piece = rgba.subspan(first, std::min(kPieceValues, rgba.size() - first));
    if (impl_->curve != nullptr) {
      for (size_t i = 0; i + 3 < piece.size(); i += 4) {
        const Rgb mapped = impl_->curve(Rgb(piece[i], piece[i + 1], piece[i + 2]) * impl_->curve_scale);
        std::copy_n(&mapped.x, 3, &piece[i]);
      }
    }
    if (impl_->processor) {
      ocio::PackedImageDesc description(piece.data(), static_cast<long>(piece.size() / 4), 1, 4);
      impl_->processor->apply(description);
    }
  }
}

const std::string& DisplayTransform::view() const { return impl_->view; }
const std::vector<std::filesystem::path>& DisplayTransform::files() const { return impl_->files; }

} // namespace kindling
