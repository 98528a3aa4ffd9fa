// Videos of frames: ffmpeg as a child process that gets raw frames through a pipe.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"
#include "renderer/base/result.h"

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <sys/types.h>

namespace kindling::app {

// True for .mp4, .webm and .gif, in any case.
[[nodiscard]] bool is_video(const std::filesystem::path& path);

// Returns the program: $KINDLING_FFMPEG (empty: none), else ffmpeg in $PATH. Nothing if there is
// none.
[[nodiscard]] std::optional<std::filesystem::path> find_ffmpeg();

// Returns ffmpeg's arguments that choose codec and quality by the extension of the video.
[[nodiscard]] std::vector<std::string> encoding_arguments(const std::filesystem::path& video);

// Returns a command for a shell that makes the video from PNG files of these names
// ("spin-####.png"), the first of which has the number `first`.
[[nodiscard]] std::string video_command(const std::filesystem::path& frames, int first, double frames_per_s,
                                        const std::filesystem::path& video);

// Encodes frames into a temporary file, which replaces the video when all frames are there.
class VideoWriter {
 public:
  VideoWriter(std::filesystem::path ffmpeg, std::filesystem::path video, double frames_per_s);
  // Without finish(), ends the process and leaves an older video unchanged.
  ~VideoWriter();
  VideoWriter(const VideoWriter&) = delete;
  VideoWriter& operator=(const VideoWriter&) = delete;

  // Adds a frame: 8-bit RGB, rows from the top. The first one starts the process. Fails
  // (input_output) if a frame has another size than the first one, and if ffmpeg cannot be run or
  // has ended, with its message.
  [[nodiscard]] Result<void> add(std::span<const uint8_t> rgb, const V2i& size_px);
  // Waits for the end of the process and puts the video in place. Fails (input_output) with
  // ffmpeg's message, if there is no frame, or if the file cannot be written.
  [[nodiscard]] Result<void> finish();

  [[nodiscard]] const std::filesystem::path& file() const { return video_; }

 private:
  [[nodiscard]] Result<void> start(const V2i& size_px);
  // Waits for the process. Returns its last message if it failed.
  [[nodiscard]] Result<void> wait();
  void close_pipe();

  std::filesystem::path ffmpeg_, video_, temporary_;
  double frames_per_s_;
  V2i size_px_{0, 0};
  pid_t process_ = -1;
  int pipe_ = -1;     // its standard input
  int messages_ = -1; // a file in memory: its standard error
};

} // namespace kindling::app
