// Starts ffmpeg, feeds it, and moves its file into place.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/output/video.h"

#include "renderer/app/text/text_format.h"
#include "renderer/image/atomic_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cctype>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fstream>

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

extern char** environ;

namespace kindling::app {

namespace fs = std::filesystem;

namespace {

std::string lower_extension(const fs::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension;
}

Error failure(const fs::path& video, const std::string& reason) {
  return {ErrorKind::input_output, fmt::format("{}: {}", video.string(), reason)};
}

// Returns the last line of ffmpeg's messages, which says why it ended.
std::string last_line(int file) {
  constexpr off_t kMax = 4096;
  const off_t size = lseek(file, 0, SEEK_END);
  std::string text(static_cast<size_t>(std::clamp<off_t>(size, 0, kMax)), '\0');
  const ssize_t count = pread(file, text.data(), text.size(), std::max<off_t>(size - kMax, 0));
  text.resize(static_cast<size_t>(std::max<ssize_t>(count, 0)));
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.back())) != 0) text.pop_back();
  return text.substr(text.find_last_of('\n') + 1); // npos + 1 is 0
}

Result<fs::path> create_temporary(const fs::path& video) {
  std::error_code code;
  const fs::path folder = fs::temp_directory_path(code);
  if (code) return failure(video, fmt::format("no folder for temporary files: {}", code.message()));
  const std::string extension = lower_extension(video);
  std::string name = (folder / "kindling-XXXXXX").string() + extension;
  const int file = mkostemps(name.data(), static_cast<int>(extension.size()), O_CLOEXEC);
  if (file < 0) return failure(video, fmt::format("{}: {}", folder.string(), std::strerror(errno)));
  close(file);
  return fs::path(name);
}

Result<void> move_file(const fs::path& from, const fs::path& to) {
  std::ifstream in(from, std::ios::binary);
  Result<AtomicFile> out = AtomicFile::create(to);
  if (!out.ok()) return out.error();
  std::array<char, 65536> buffer;
  while (in.read(buffer.data(), buffer.size()) || in.gcount() > 0)
    out.value().write(buffer.data(), static_cast<size_t>(in.gcount()));
  if (in.bad() || !in.eof()) return failure(to, fmt::format("{} cannot be read back", from.string()));
  return out.value().commit();
}

} // namespace

bool is_video(const fs::path& path) {
  const std::string extension = lower_extension(path);
  return extension == ".mp4" || extension == ".webm" || extension == ".gif";
}

std::optional<fs::path> find_ffmpeg() {
  if (const char* chosen = std::getenv("KINDLING_FFMPEG"))
    return *chosen != '\0' ? std::optional<fs::path>(chosen) : std::nullopt;
  const char* const variable = std::getenv("PATH");
  std::string_view folders = variable != nullptr ? variable : "";
  while (!folders.empty()) {
    const std::string_view folder = folders.substr(0, folders.find(':'));
    folders.remove_prefix(std::min(folder.size() + 1, folders.size()));
    if (folder.empty()) continue;
    fs::path file = fs::path(folder) / "ffmpeg";
    if (access(file.c_str(), X_OK) == 0) return file;
  }
  return std::nullopt;
}

std::vector<std::string> encoding_arguments(const fs::path& video) {
  const std::string extension = lower_extension(video);
  if (extension == ".gif")
    return {"-vf", "split[a][b];[a]palettegen=stats_mode=full[p];[b][p]paletteuse=dither=sierra2_4a", "-loop", "0"};
  // Codecs of 4:2:0 need even sides; colors are those of the PNG files (sRGB), as BT.709 video.
  std::vector<std::string> arguments{"-vf",
                                     "pad=ceil(iw/2)*2:ceil(ih/2)*2,scale=out_color_matrix=bt709",
                                     "-pix_fmt",
                                     "yuv420p",
                                     "-colorspace",
                                     "bt709",
                                     "-color_trc",
                                     "bt709",
                                     "-color_range",
                                     "tv",
                                     "-color_primaries",
                                     "bt709"};
  const std::vector<std::string> codec =
      extension == ".webm" ? std::vector<std::string>{"-c:v", "libvpx-vp9", "-crf", "24", "-b:v", "0", "-row-mt", "1"}
                           : std::vector<std::string>{"-c:v", "libx264", "-crf", "18", "-movflags", "+faststart"};
  arguments.insert(arguments.end(), codec.begin(), codec.end());
  return arguments;
}

std::string video_command(const fs::path& frames, int first, double frames_per_s, const fs::path& video) {
  std::string name = frames.string();
  if (const size_t begin = name.find('#'); begin != std::string::npos) {
    const size_t end = std::min(name.find_first_not_of('#', begin), name.size());
    name.replace(begin, end - begin, fmt::format("%0{}d", end - begin));
  }
  std::string command =
      fmt::format("ffmpeg -framerate {:g} -start_number {} -i {}", frames_per_s, first, shell_quote(name));
  for (const std::string& argument : encoding_arguments(video)) command += ' ' + shell_quote(argument);
  return command + ' ' + shell_quote(video.string());
}

VideoWriter::VideoWriter(fs::path ffmpeg, fs::path video, double frames_per_s)
    : ffmpeg_(std::move(ffmpeg)), video_(std::move(video)), frames_per_s_(frames_per_s) {}

VideoWriter::~VideoWriter() {
  if (process_ > 0) {
    kill(process_, SIGKILL);
    (void)wait();
  }
  close_pipe();
  if (messages_ >= 0) close(messages_);
  std::error_code ignored;
  if (!temporary_.empty()) fs::remove(temporary_, ignored);
}

void VideoWriter::close_pipe() {
  if (pipe_ >= 0) close(pipe_);
  pipe_ = -1;
}

Result<void> VideoWriter::start(const V2i& size_px) {
  size_px_ = size_px;
  Result<fs::path> temporary = create_temporary(video_);
  if (!temporary.ok()) return temporary.error();
  temporary_ = std::move(temporary).value();
  messages_ = memfd_create("ffmpeg", MFD_CLOEXEC);
  std::array<int, 2> ends{-1, -1};
  if (messages_ < 0 || pipe2(ends.data(), O_CLOEXEC) != 0)
    return failure(video_, fmt::format("no pipe to ffmpeg: {}", std::strerror(errno)));
  pipe_ = ends[1];
  std::vector<std::string> words{ffmpeg_.string(),
                                 "-hide_banner",
                                 "-loglevel",
                                 "error",
                                 "-y",
                                 "-f",
                                 "rawvideo",
                                 "-pix_fmt",
                                 "rgb24",
                                 "-s",
                                 fmt::format("{}x{}", size_px.x, size_px.y),
                                 "-r",
                                 fmt::format("{:g}", frames_per_s_),
                                 "-i",
                                 "pipe:0"};
  for (std::string& argument : encoding_arguments(video_)) words.push_back(std::move(argument));
  words.push_back("file:" + temporary_.string());
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);

  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, ends[0], STDIN_FILENO);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_adddup2(&actions, messages_, STDERR_FILENO);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t pipes;
  sigemptyset(&pipes);
  sigaddset(&pipes, SIGPIPE); // ignored in this process
  posix_spawnattr_setsigdefault(&attributes, &pipes);
  posix_spawnattr_setpgroup(&attributes, 0); // Ctrl-C in the terminal is for this process alone
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP);
  const int error = posix_spawnp(&process_, arguments[0], &actions, &attributes, arguments.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  close(ends[0]);
  if (error == 0) return {};
  process_ = -1;
  return failure(video_, fmt::format("{}: cannot be run: {}", ffmpeg_.string(), std::strerror(error)));
}

Result<void> VideoWriter::wait() {
  int status = 0;
  while (waitpid(process_, &status, 0) < 0 && errno == EINTR) {
  }
  process_ = -1;
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return {};
  const std::string message = last_line(messages_);
  return failure(video_, fmt::format("ffmpeg failed: {}", !message.empty()      ? message
                                                          : WIFSIGNALED(status) ? strsignal(WTERMSIG(status))
                                                                                : "no message"));
}

Result<void> VideoWriter::add(std::span<const uint8_t> rgb, const V2i& size_px) {
  if (process_ <= 0 && temporary_.empty())
    if (Result<void> started = start(size_px); !started.ok()) return started;
  if (process_ <= 0) return failure(video_, "ffmpeg has ended"); // after an error that was returned before
  if (size_px != size_px_)
    return failure(video_,
                   fmt::format("a frame has {}x{} pixels, the first one {}x{}; --force renders all frames again",
                               size_px.x, size_px.y, size_px_.x, size_px_.y));
  assert(rgb.size() == 3 * static_cast<size_t>(size_px.x) * static_cast<size_t>(size_px.y));
  while (!rgb.empty()) {
    const ssize_t count = ::write(pipe_, rgb.data(), rgb.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) { // EPIPE: it has ended
      const int error = errno;
      close_pipe();
      if (Result<void> ended = wait(); !ended.ok()) return ended;
      return failure(video_, fmt::format("ffmpeg takes no more frames: {}", std::strerror(error)));
    }
    rgb = rgb.subspan(static_cast<size_t>(count));
  }
  return {};
}

Result<void> VideoWriter::finish() {
  if (process_ <= 0) return failure(video_, "there are no frames");
  close_pipe();
  if (Result<void> ended = wait(); !ended.ok()) return ended;
  return move_file(temporary_, video_);
}

} // namespace kindling::app
