// Writing of films: selection of the format by extension, layers and channel names.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/film/write_film.h"

#include "renderer/image/atomic_file.h"
#include "renderer/image/write_image.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <string_view>
#include <utility>

namespace kindling {

namespace {

// Light passes have Blender's names.
std::string_view layer_name(Aov aov) {
  switch (aov) {
  case Aov::diffuse_direct: return "DiffDir";
  case Aov::diffuse_indirect: return "DiffInd";
  case Aov::glossy_direct: return "GlossDir";
  case Aov::glossy_indirect: return "GlossInd";
  case Aov::transmission_direct: return "TransDir";
  case Aov::transmission_indirect: return "TransInd";
  case Aov::volume_direct: return "VolumeDir";
  case Aov::volume_indirect: return "VolumeInd";
  case Aov::emit: return "Emit";
  case Aov::environment: return "Env";
  case Aov::diffuse_color: return "DiffCol";
  case Aov::glossy_color: return "GlossCol";
  case Aov::transmission_color: return "TransCol";
  default: return aov_info(aov).name;
  }
}

} // namespace

std::vector<std::string> channel_names(Aov aov) {
  const std::string name(aov_info(aov).name);
  switch (aov) {
  case Aov::beauty: return {"R", "G", "B"};
  case Aov::alpha: return {"A"};
  case Aov::depth: return {"Z"};
  case Aov::samples: return {"kindling.samples"};
  case Aov::variance: return {"kindling.variance"};
  case Aov::object_id: return {"IndexOB.X"};
  case Aov::material_id: return {"IndexMA.X"};
  case Aov::uv: return {"UV.U", "UV.V", "UV.A"};
  case Aov::depth_nearest: return {"Depth.Z"};
  case Aov::position_nearest: return {"Position.X", "Position.Y", "Position.Z"};
  case Aov::vector: return {"Vector.X", "Vector.Y", "Vector.Z", "Vector.W"};
  case Aov::motion: return {"forward.u", "forward.v", "backward.u", "backward.v"};
  case Aov::normal:
  case Aov::denoising_normal:
  case Aov::position: return {name + ".X", name + ".Y", name + ".Z"};
  default: break;
  }
  if (aov_info(aov).channels == 1) return {name};
  const std::string layer(layer_name(aov));
  return {layer + ".R", layer + ".G", layer + ".B"};
}

std::vector<std::string> light_group_channels(std::string_view group) {
  const std::string layer = fmt::format("{}{}", kLightGroupLayer, group);
  return {layer + ".R", layer + ".G", layer + ".B"};
}

std::vector<float> display_rgba(std::vector<float> rgba, const DisplayTransform& view) {
  for (size_t i = 0; i + 3 < rgba.size(); i += 4) {
    const float alpha = rgba[i + 3];
    for (size_t c = 0; c < 3; ++c) rgba[i + c] = alpha > 0.0f ? rgba[i + c] / alpha : 0.0f;
  }
  view.apply(rgba);
  return rgba;
}

namespace {

enum class OutputFormat { unsupported, exr, png, jpeg };

// The names of standard output, and what is written to it.
constexpr std::array<std::pair<const char*, OutputFormat>, 4> kStandardOutputs{{{"-", OutputFormat::png},
                                                                                {"png:-", OutputFormat::png},
                                                                                {"jpg:-", OutputFormat::jpeg},
                                                                                {"exr:-", OutputFormat::exr}}};

OutputFormat output_format(const std::filesystem::path& path) {
  for (const auto& [name, format] : kStandardOutputs)
    if (path == name) return format;
  std::string extension = path.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (extension == ".exr") return OutputFormat::exr;
  if (extension == ".png") return OutputFormat::png;
  if (extension == ".jpg" || extension == ".jpeg") return OutputFormat::jpeg;
  return OutputFormat::unsupported;
}

constexpr float kLargestHalf = 65504.0f;

std::vector<float> rgba_of(const Film& film, const WriteOptions& options) {
  return options.denoised.empty() ? film.resolve_rgba()
                                  : std::vector<float>(options.denoised.begin(), options.denoised.end());
}

ExrLayer make_layer(std::vector<std::string> names, bool half, std::vector<float> values) {
  // Values beyond the largest half would become infinite and spoil any later filtering.
  if (half)
    for (float& value : values) value = std::clamp(value, -kLargestHalf, kLargestHalf);
  return {std::move(names), half, std::move(values)};
}

Result<void> write_film_exr(const std::filesystem::path& path, const Film& film, const ImageMetadata& metadata,
                            const WriteOptions& options) {
  ExrImage image;
  image.display_size_px = film.size_px();
  image.data_min_px = film.crop().min;
  image.data_max_px = film.crop().max;
  image.layers.push_back(make_layer({"R", "G", "B", "A"}, options.half, rgba_of(film, options)));
  if (!options.denoised.empty())
    image.layers.push_back(make_layer({"noisy.R", "noisy.G", "noisy.B"}, options.half, film.resolve(Aov::beauty)));
  for (const AovInfo& info : kAovs) {
    if (info.aov == Aov::beauty || info.aov == Aov::alpha || !film.aovs().contains(info.aov)) continue;
    image.layers.push_back(make_layer(channel_names(info.aov), info.half && options.half, film.resolve(info.aov)));
  }
  for (size_t i = 0; i < film.light_groups().size(); ++i)
    image.layers.push_back(
        make_layer(light_group_channels(film.light_groups()[i]), options.half, film.resolve_light_group(i)));
  for (const MatteInfo& info : kMattes) {
    if (!film.aovs().contains(info.matte)) continue;
    const std::vector<std::string> names = matte_channel_names(info.matte, options.matte_levels);
    image.layers.push_back({names, false, film.resolve_matte(info.matte, static_cast<int>(names.size() / 2))});
  }
  image.text = metadata.text;
  image.numbers = metadata.numbers;
  image.integers = metadata.integers;
  image.matrices["worldToCamera"] = metadata.world_to_camera;
  image.matrices["worldToNDC"] = metadata.world_to_ndc;
  return write_exr(path, image);
}

// Metadata for formats that hold text only.
std::map<std::string, std::string> as_text(const ImageMetadata& metadata, const DisplayTransform& view) {
  std::map<std::string, std::string> text = metadata.text;
  std::erase_if(text, [](const auto& entry) { return entry.first.starts_with("cryptomatte/"); }); // of EXR layers
  for (const auto& [key, value] : metadata.numbers) text[key] = fmt::format("{:g}", value);
  for (const auto& [key, value] : metadata.integers) text[key] = fmt::format("{}", value);
  text["kindling:view"] = view.view();
  return text;
}

// Returns premultiplied pixels over black, through the view.
std::vector<float> display_rgb(std::vector<float> rgba, const DisplayTransform& view) {
  view.apply(rgba);
  std::vector<float> rgb(rgba.size() / 4 * 3);
  for (size_t i = 0; i < rgba.size() / 4; ++i) std::copy_n(&rgba[4 * i], 3, &rgb[3 * i]);
  return rgb;
}

std::filesystem::path target_of(const std::filesystem::path& path) {
  return is_standard_output(path) ? std::filesystem::path(kStandardOutput) : path;
}

} // namespace

Result<void> write_film(const std::filesystem::path& path, const Film& film, const DisplayTransform& view,
                        const ImageMetadata& metadata, const WriteOptions& options) {
  if (output_format(path) == OutputFormat::exr) return write_film_exr(target_of(path), film, metadata, options);
  const V2i size_px(film.crop().width(), film.crop().height());
  return write_display_file(path, rgba_of(film, options), size_px, view, as_text(metadata, view), options);
}

Result<void> write_display_file(const std::filesystem::path& path, std::vector<float> rgba, const V2i& size_px,
                                const DisplayTransform& view, const std::map<std::string, std::string>& text,
                                const WriteOptions& options) {
  switch (output_format(path)) {
  case OutputFormat::png:
    return write_png(target_of(path), display_rgba(std::move(rgba), view), size_px, options.png_bits, text);
  case OutputFormat::jpeg:
    return write_jpeg(target_of(path), display_rgb(std::move(rgba), view), size_px, options.jpeg_quality, text);
  default: return Error{ErrorKind::usage, unsupported_output(path)};
  }
}

bool is_standard_output(const std::filesystem::path& path) {
  return std::ranges::any_of(kStandardOutputs, [&](const auto& output) { return path == output.first; });
}

std::vector<uint8_t> display_rgba8(const Film& film, const DisplayTransform& view) {
  return quantize_8bit(display_rgba(film.resolve_rgba(), view));
}

std::vector<uint8_t> display_rgb8(const Film& film, const DisplayTransform& view, const WriteOptions& options) {
  return quantize_8bit(display_rgb(rgba_of(film, options), view));
}

std::string unsupported_output(const std::filesystem::path& path) {
  if (output_format(path) != OutputFormat::unsupported) return {};
  const std::string extension = path.extension().string();
  if (extension.empty())
    return fmt::format("{}: the file name has no extension; use .exr, .png or .jpg", path.string());
  return fmt::format("{}: unsupported image format '{}'; use .exr, .png or .jpg", path.string(), extension);
}

} // namespace kindling
