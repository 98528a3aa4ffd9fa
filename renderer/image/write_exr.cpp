// Writer of multi-layer EXR files: the channels of all layers in one part, each half or float.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/write_image.h"

#include "renderer/image/atomic_file.h"
#include "renderer/image/decoders.h"

#include <OpenEXR/openexr.h>
#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <exception>
#include <optional>
#include <string_view>

#include <half.h>

namespace kindling {

namespace {

// The source of one channel of the file.
struct ChannelSource {
  std::string name;
  bool half = true;
  const float* values = nullptr; // of the first pixel
  size_t stride = 0;             // floats from pixel to pixel

  [[nodiscard]] size_t bytes() const { return half ? 2 : 4; }
};

// Returns all channels sorted by name, as OpenEXR stores them.
std::vector<ChannelSource> sorted_channels(const ExrImage& image) {
  std::vector<ChannelSource> channels;
  for (const ExrLayer& layer : image.layers) {
    for (size_t c = 0; c < layer.channel_names.size(); ++c) {
      channels.push_back({layer.channel_names[c], layer.half, layer.values.data() + c, layer.channel_names.size()});
    }
  }
  std::sort(channels.begin(), channels.end(), [](const auto& a, const auto& b) { return a.name < b.name; });
  return channels;
}

std::optional<std::string> check(const ExrImage& image, const std::vector<ChannelSource>& channels) {
  if (image.display_size_px.x < 1 || image.display_size_px.y < 1) return "its display window is empty";
  const V2i size = image.data_max_px - image.data_min_px;
  if (size.x < 1 || size.y < 1) return "its data window is empty";
  if (channels.empty()) return "it has no channels";
  for (size_t i = 0; i < channels.size(); ++i) {
    if (channels[i].name.empty()) return "a channel has no name";
    if (i > 0 && channels[i].name == channels[i - 1].name) return "there are two channels '" + channels[i].name + "'";
  }
  const size_t pixel_count = static_cast<size_t>(size.x) * static_cast<size_t>(size.y);
  for (const ExrLayer& layer : image.layers) {
    if (layer.values.size() != pixel_count * layer.channel_names.size()) {
      const std::string name = layer.channel_names.empty() ? "" : layer.channel_names[0];
      return "the layer of channel '" + name + "' has " + std::to_string(layer.values.size()) +
             " values; its data window needs " + std::to_string(pixel_count * layer.channel_names.size());
    }
  }
  return std::nullopt;
}

// ---- OpenEXR's C library, which needs no global thread pool and writes to an AtomicFile

// Write errors are not passed to the library; the file returns them at commit().
int64_t write_bytes(exr_const_context_t, void* file, const void* data, uint64_t size, uint64_t offset,
                    exr_stream_error_func_ptr_t) {
  static_cast<AtomicFile*>(file)->seek(static_cast<int64_t>(offset));
  static_cast<AtomicFile*>(file)->write(data, size);
  return static_cast<int64_t>(size);
}
void keep_file(exr_const_context_t, void*, int) {}
// Replaces the default handler, which prints; result codes suffice.
void ignore_message(exr_const_context_t, exr_result_t, const char*) {}

// Returns the message for a result code; empty on success.
std::string explain(exr_result_t code, std::string_view what) {
  if (code == EXR_ERR_SUCCESS) return {};
  return fmt::format("{}: {}", what, exr_get_default_error_message(code));
}

class ExrContext {
 public:
  ExrContext() = default;
  ~ExrContext() {
    if (handle) exr_finish(&handle);
  }
  ExrContext(const ExrContext&) = delete;
  ExrContext& operator=(const ExrContext&) = delete;

  exr_context_t handle = nullptr;
};

// Sets the required attributes, the channels, and the attributes of the caller.
std::string set_header(exr_context_t context, const ExrImage& image, const std::vector<ChannelSource>& channels) {
  std::string error;
  const auto done = [&error](exr_result_t code, std::string_view what) {
    if (error.empty()) error = explain(code, what);
  };
  size_t longest = 0;
  const auto measure = [&longest](const auto& named) {
    for (const auto& [name, value] : named) longest = std::max(longest, name.size());
  };
  for (const ChannelSource& channel : channels) longest = std::max(longest, channel.name.size());
  measure(image.text);
  measure(image.numbers);
  measure(image.integers);
  measure(image.matrices);
  constexpr size_t kShortName = 31; // longer names set a flag in the file's version, so that old readers refuse it
  if (longest > kShortName) done(exr_set_longname_support(context, 1), "long names");

  int part = 0;
  done(exr_add_part(context, nullptr, EXR_STORAGE_SCANLINE, &part), "part");
  const exr_attr_box2i_t display{{0, 0}, {image.display_size_px.x - 1, image.display_size_px.y - 1}};
  const exr_attr_box2i_t data{{image.data_min_px.x, image.data_min_px.y},
                              {image.data_max_px.x - 1, image.data_max_px.y - 1}};
  const exr_attr_v2f_t screen_center{0.0f, 0.0f};
  done(exr_initialize_required_attr(context, part, &display, &data, 1.0f, &screen_center, 1.0f,
                                    EXR_LINEORDER_INCREASING_Y, EXR_COMPRESSION_ZIP),
       "header");
  for (const ChannelSource& channel : channels) {
    done(exr_add_channel(context, part, channel.name.c_str(), channel.half ? EXR_PIXEL_HALF : EXR_PIXEL_FLOAT,
                         EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1),
         "channel " + channel.name);
  }
  // ITU-R BT.709 primaries and white point D65: x and y of red, green, blue and white.
  const exr_attr_chromaticities_t rec709{0.64f, 0.33f, 0.30f, 0.60f, 0.15f, 0.06f, 0.3127f, 0.3290f};
  done(exr_attr_set_chromaticities(context, part, "chromaticities", &rec709), "attribute chromaticities");
  for (const auto& [name, value] : image.text) {
    done(exr_attr_set_string(context, part, name.c_str(), value.c_str()), "attribute " + name);
  }
  for (const auto& [name, value] : image.numbers) {
    done(exr_attr_set_float(context, part, name.c_str(), value), "attribute " + name);
  }
  for (const auto& [name, value] : image.integers) {
    done(exr_attr_set_int(context, part, name.c_str(), value), "attribute " + name);
  }
  for (const auto& [name, value] : image.matrices) {
    exr_attr_m44f_t matrix;
    std::memcpy(matrix.m, value.getValue(), sizeof matrix.m);
    done(exr_attr_set_m44f(context, part, name.c_str(), &matrix), "attribute " + name);
  }
  done(exr_write_header(context), "header");
  return error;
}

// ---- pixels

// Converts to half; finite values remain finite.
Imath::half to_half(float value) {
  constexpr float kHalfMax = 65504.0f;
  return Imath::half(std::isfinite(value) ? std::clamp(value, -kHalfMax, kHalfMax) : value);
}

// Returns rows [first_row, last_row) of the data window, channel after channel, each in its own
// type.
std::vector<std::byte> pack_rows(const std::vector<ChannelSource>& channels, size_t width, size_t first_row,
                                 size_t last_row) {
  const size_t count = (last_row - first_row) * width;
  size_t pixel_bytes = 0;
  for (const ChannelSource& channel : channels) pixel_bytes += channel.bytes();
  std::vector<std::byte> packed(count * pixel_bytes);
  std::byte* out = packed.data();
  for (const ChannelSource& channel : channels) {
    const float* in = channel.values + first_row * width * channel.stride;
    for (size_t i = 0; i < count; ++i, out += channel.bytes(), in += channel.stride) {
      if (channel.half) {
        const Imath::half value = to_half(*in);
        std::memcpy(out, &value, sizeof value);
      } else {
        std::memcpy(out, in, sizeof *in);
      }
    }
  }
  return packed;
}

class ExrEncoder {
 public:
  explicit ExrEncoder(exr_context_t context) : context_(context) {}
  ~ExrEncoder() { exr_encoding_destroy(context_, &pipeline_); }
  ExrEncoder(const ExrEncoder&) = delete;
  ExrEncoder& operator=(const ExrEncoder&) = delete;

  // Compresses the chunk that starts at line `y`. `packed` are its rows from pack_rows().
  exr_result_t run(int y, const std::vector<std::byte>& packed, std::vector<std::byte>& compressed) {
    exr_chunk_info_t chunk{};
    exr_result_t code = exr_write_scanline_chunk_info(context_, 0, y, &chunk);
    if (code == EXR_ERR_SUCCESS) code = exr_encoding_initialize(context_, 0, &chunk, &pipeline_);
    if (code != EXR_ERR_SUCCESS) return code;
    const std::byte* plane = packed.data();
    for (int16_t c = 0; c < pipeline_.channel_count; ++c) {
      exr_coding_channel_info_t& channel = pipeline_.channels[c];
      channel.encode_from_ptr = reinterpret_cast<const uint8_t*>(plane);
      channel.user_pixel_stride = channel.bytes_per_element;
      channel.user_line_stride = channel.width * channel.bytes_per_element;
      plane += static_cast<ptrdiff_t>(channel.user_line_stride) * channel.height;
    }
    code = exr_encoding_choose_default_routines(context_, 0, &pipeline_);
    if (code != EXR_ERR_SUCCESS) return code;
    pipeline_.yield_until_ready_fn = nullptr; // chunks are written in order by the caller
    pipeline_.write_fn = nullptr;
    code = exr_encoding_run(context_, 0, &pipeline_);
    if (code != EXR_ERR_SUCCESS) return code;
    const auto* bytes = static_cast<const std::byte*>(pipeline_.compressed_buffer);
    compressed.assign(bytes, bytes + pipeline_.compressed_bytes);
    return EXR_ERR_SUCCESS;
  }

 private:
  exr_context_t context_;
  exr_encode_pipeline_t pipeline_{};
};

// Writes bands of several chunks, which are compressed in parallel and written in order, to bound
// memory.
std::string write_pixels(exr_context_t context, const ExrImage& image, const std::vector<ChannelSource>& channels) {
  constexpr size_t kBandBytes = size_t{16} << 20, kChunkRows = 16; // ZIP compresses 16 rows together
  const V2i size = image.data_max_px - image.data_min_px;
  const auto width = static_cast<size_t>(size.x), height = static_cast<size_t>(size.y);
  size_t row_bytes = 0;
  for (const ChannelSource& channel : channels) row_bytes += channel.bytes() * width;
  const size_t chunk_count = (height + kChunkRows - 1) / kChunkRows;
  const size_t band_chunks = std::clamp<size_t>(kBandBytes / (row_bytes * kChunkRows), 1, chunk_count);
  const auto first_line = [&](size_t chunk) { return image.data_min_px.y + static_cast<int>(chunk * kChunkRows); };

  struct Chunk {
    std::vector<std::byte> compressed;
    exr_result_t code = EXR_ERR_SUCCESS;
  };
  std::vector<Chunk> chunks(band_chunks);
  for (size_t band = 0; band < chunk_count; band += band_chunks) {
    const size_t end = std::min(band + band_chunks, chunk_count);
    tbb::parallel_for(band, end, [&](size_t i) {
      const std::vector<std::byte> packed =
          pack_rows(channels, width, i * kChunkRows, std::min((i + 1) * kChunkRows, height));
      Chunk& chunk = chunks[i - band];
      chunk.code = ExrEncoder(context).run(first_line(i), packed, chunk.compressed);
    });
    for (size_t i = band; i < end; ++i) {
      const Chunk& chunk = chunks[i - band];
      if (chunk.code != EXR_ERR_SUCCESS) return explain(chunk.code, "pixels");
      const exr_result_t code =
          exr_write_scanline_chunk(context, 0, first_line(i), chunk.compressed.data(), chunk.compressed.size());
      if (code != EXR_ERR_SUCCESS) return explain(code, "pixels");
    }
  }
  return {};
}

// Writes an image; returns an empty string on success, else the detail of the error.
std::string write_exr_to(AtomicFile& file, const ExrImage& image, const std::vector<ChannelSource>& channels) {
  exr_context_initializer_t options = EXR_DEFAULT_CONTEXT_INITIALIZER;
  options.error_handler_fn = ignore_message;
  options.user_data = &file;
  options.write_fn = write_bytes;
  options.destroy_fn = keep_file;
  ExrContext context;
  const exr_result_t started = exr_start_write(&context.handle, "an EXR", EXR_WRITE_FILE_DIRECTLY, &options);
  if (started != EXR_ERR_SUCCESS) return explain(started, "start");
  if (std::string error = set_header(context.handle, image, channels); !error.empty()) return error;
  if (std::string error = write_pixels(context.handle, image, channels); !error.empty()) return error;
  return explain(exr_finish(&context.handle), "end");
}

} // namespace

Result<void> write_exr(const std::filesystem::path& path, const ExrImage& image) {
  const auto failed = [&](const std::string& why) {
    return Error{ErrorKind::input_output, path.string() + ": cannot write EXR: " + image_detail::first_line(why)};
  };
  try {
    const std::vector<ChannelSource> channels = sorted_channels(image);
    if (const auto error = check(image, channels)) return failed(*error);
    Result<AtomicFile> file = AtomicFile::create(path);
    if (!file) return file.error();
    if (const std::string error = write_exr_to(file.value(), image, channels); !error.empty()) return failed(error);
    return file.value().commit();
  } catch (const std::exception& e) {
    return failed(e.what());
  }
}

} // namespace kindling
