// A scene that is rendered while its camera and settings change: the loop behind the pages.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/progress.h"
#include "renderer/base/result.h"
#include "renderer/denoise/denoiser.h"
#include "renderer/facade/renderer.h"
#include "renderer/view/frame.h"
#include "renderer/view/frame_header.h"
#include "renderer/view/view_state.h"

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <shared_mutex>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

namespace kindling {

// A frame as it is sent. A new version with the same image has other numbers in its header.
struct SentFrame {
  uint64_t version = 0;
  uint64_t image = 0;                      // number of the image: that of the version in which it was new
  std::string header;                      // JSON
  std::shared_ptr<const std::string> jpeg; // null until there is an image
};

struct SavedFrame {
  std::string file_name;
  std::string content_type;
  std::string bytes;
};

// One scene, one state and one image for all pages. While the state changes, quick images follow
// it; a fifth of a second after the last change the whole image is rendered and refined until it
// has ViewState::spp samples. Threads of its own render, display, and watch the files of the scene.
// All functions but the constructor may be called from any thread.
class ViewSession {
 public:
  struct Settings {
    std::filesystem::path scene_file;
    ViewOptions options;
    std::vector<std::string> passed_on; // flags for command_words()
    // Joins words to a command line of a shell.
    std::function<std::string(const std::vector<std::string>&)> join;
    std::function<void(std::string_view)> on_warning; // of loading and rendering
  };
  // Loads the scene. Fails as Renderer::load() and DisplayTransform::create() do.
  [[nodiscard]] static Result<std::unique_ptr<ViewSession>> open(Settings settings, ProgressListener& listener);
  ~ViewSession(); // stops
  ViewSession(const ViewSession&) = delete;
  ViewSession& operator=(const ViewSession&) = delete;

  void start();
  void stop(); // within the time that a few blocks take

  // Applies a change of the state (apply_json()), and fails as that does.
  [[nodiscard]] Result<void> change(std::string_view json);
  // Waits for a frame with a later version than `after`; null if there is none in that time.
  [[nodiscard]] std::shared_ptr<const SentFrame> wait_for_frame(uint64_t after, double seconds);
  // Returns the cameras, variants, scenes, views and times to choose from, as JSON.
  [[nodiscard]] std::string description() const;
  // Returns the values at a position of the image (Renderer::pick()), as JSON.
  [[nodiscard]] std::string describe_pixel(const V2f& position) const;
  // Renders a sample of the pixel at a position again (Renderer::replay()). Returns its path, as
  // JSON. Fails (usage) as that does, and while another path is traced.
  [[nodiscard]] Result<std::string> describe_path(const V2f& position, uint32_t sample) const;
  // Returns the last displayed image as a file. Fails (usage) if there is none, or as make_file().
  [[nodiscard]] Result<SavedFrame> save(FileKind kind) const;

 private:
  using Clock = std::chrono::steady_clock;
  enum class Task { stop, load, moving, whole };

  // Files and their times as they were read.
  struct WatchedFiles {
    std::vector<std::filesystem::path> names;
    std::vector<std::pair<std::filesystem::file_time_type, uintmax_t>> times; // and sizes
  };
  // A file that has changed since `load_start` gets no time, so that it counts as changed.
  [[nodiscard]] static WatchedFiles watched_files(const Renderer& renderer, std::filesystem::file_time_type load_start);

  ViewSession(Settings settings, Renderer renderer, WatchedFiles files);
  void render_loop();
  void display_loop();
  void watch_loop();
  [[nodiscard]] Task next_task(ViewState& state, uint64_t& revision);
  void describe();
  bool replace_renderer(const ViewState& state);
  void load(const ViewState& state);
  void render_moving(const ViewState& state, uint64_t revision);
  void render_whole(const ViewState& state, uint64_t revision);
  // Renders and shows each pass. Returns the seconds that it took, or nothing if it failed or was
  // cancelled.
  std::optional<double> render(const ViewState& state, const ImageSettings& image, const CancelToken& cancel,
                               bool moving);
  void show(LinearFrame frame);
  void set_status(const std::string& status);
  void fail(const std::string& message);
  void publish(const LinearFramePointer& frame, const DisplayedFrame* displayed);
  [[nodiscard]] CameraSeen camera_seen(const PlacedCamera& camera) const;

  Settings settings_;
  std::jthread renders_, displays_, watches_;

  mutable std::shared_mutex renderer_mutex_; // held exclusively while the Renderer is replaced
  std::optional<Renderer> renderer_;
  std::string description_;       // by mutex_
  mutable std::mutex path_mutex_; // held while a path is traced

  mutable std::mutex mutex_; // guards all below
  std::condition_variable changed_;
  bool stopping_ = false;
  ViewState state_;
  uint64_t revision_ = 1;          // of all that decides the image
  uint64_t moved_ = 0, whole_ = 0; // revisions that were rendered
  Clock::time_point last_change_{};
  bool must_load_ = false;
  WatchedFiles watched_;
  std::shared_ptr<CancelToken> cancel_; // of the render that runs, if a change ends it
  LinearFramePointer latest_;           // to be displayed
  LinearFramePointer shown_;            // displayed
  uint64_t display_wanted_ = 0, display_done_ = 0;
  std::shared_ptr<const SentFrame> sent_;
  HeaderFacts facts_;
  std::optional<DisplayedFrame> displayed_;

  // Members of the rendering thread.
  bool decided_ = false; // the Renderer has made its decisions
  bool has_strokes_ = false;
  std::optional<std::pair<ViewCamera, V2i>> first_image_; // of the Renderer: its camera and size
  double paths_per_s_ = 1e6;
  uint32_t moving_frames_ = 0;
  Clock::time_point last_moving_{};

  // Members of the displaying thread, and of save(), under display_mutex_.
  mutable std::mutex display_mutex_;
  FrameDisplay display_;
  std::optional<Result<Denoiser>> denoiser_;

  std::atomic<uint64_t> rays_{0}; // of the render that runs
};

} // namespace kindling
