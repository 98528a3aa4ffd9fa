// The state of a view, and what its pages ask of it.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/view/view_session.h"

#include "renderer/view/command_words.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace kindling {

namespace {

// Tells a ProgressListener what a RunOptions reports.
RunOptions reporting_to(ProgressListener& listener, int threads) {
  RunOptions run;
  run.threads = threads;
  run.on_progress = [&listener](const ProgressSnapshot& snapshot) { listener.on_progress(snapshot); };
  run.on_warning = [&listener](std::string_view message) { listener.on_warning(message); };
  return run;
}

} // namespace

Result<std::unique_ptr<ViewSession>> ViewSession::open(Settings settings, ProgressListener& listener) {
  FrameDisplay display;
  const ViewOptions& options = settings.options;
  if (Result<void> chosen = display.choose(options.display_view, options.exposure_stops, options.ocio_config);
      !chosen.ok())
    return chosen.error();
  const auto load_start = std::filesystem::file_time_type::clock::now();
  Result<Renderer> renderer =
      Renderer::load(settings.scene_file, options.world, reporting_to(listener, options.threads));
  if (!renderer.ok()) return renderer.error();
  WatchedFiles files = watched_files(renderer.value(), load_start);
  return std::unique_ptr<ViewSession>(
      new ViewSession(std::move(settings), std::move(renderer).value(), std::move(files)));
}

ViewSession::ViewSession(Settings settings, Renderer renderer, WatchedFiles files)
    : settings_(std::move(settings)), renderer_(std::move(renderer)), state_(initial_state(settings_.options)),
      watched_(std::move(files)) {
  constexpr int kFirstWidth = 960, kFirstHeight = 540; // until a page has another size
  if (state_.size_px.x == 0) state_.size_px = V2i(kFirstWidth, kFirstHeight);
}

ViewSession::~ViewSession() { stop(); }

void ViewSession::start() {
  renders_ = std::jthread([this] { render_loop(); });
  displays_ = std::jthread([this] { display_loop(); });
  watches_ = std::jthread([this] { watch_loop(); });
}

void ViewSession::stop() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
    if (cancel_) cancel_->cancel_now();
  }
  changed_.notify_all();
  for (std::jthread* thread : {&renders_, &displays_, &watches_})
    if (thread->joinable()) thread->join();
}

Result<void> ViewSession::change(std::string_view json) {
  {
    const std::lock_guard lock(mutex_);
    ViewState changed = state_;
    if (Result<void> applied = apply_json(json, changed); !applied.ok()) return applied;
    const ViewChange change = compare(state_, changed);
    if (change == ViewChange::none) return {};
    // Denoising needs other data of the samples, and pixels that share no paths.
    const bool renders = change >= ViewChange::image || changed.denoise != state_.denoise;
    state_ = changed;
    if (!renders) {
      ++display_wanted_; // of the last frame
    } else {
      ++revision_;
      last_change_ = Clock::now();
      facts_.error.clear();
      if (cancel_) cancel_->cancel_now();
    }
    if (change == ViewChange::world) must_load_ = true;
  }
  changed_.notify_all();
  return {};
}

std::shared_ptr<const SentFrame> ViewSession::wait_for_frame(uint64_t after, double seconds) {
  std::unique_lock lock(mutex_);
  const auto is_later = [&] { return stopping_ || (sent_ && sent_->version > after); };
  changed_.wait_for(lock, std::chrono::duration<double>(seconds), is_later);
  return sent_ && sent_->version > after ? sent_ : nullptr;
}

std::string ViewSession::description() const {
  const std::lock_guard lock(mutex_);
  return description_;
}

std::string ViewSession::describe_pixel(const V2f& position) const {
  const auto at = [](float fraction, int size) {
    return std::clamp(static_cast<int>(fraction * static_cast<float>(size)), 0, size - 1);
  };
  LinearFramePointer frame;
  V2i pixel;
  std::optional<Rgb> denoised;
  {
    const std::lock_guard lock(mutex_);
    if (!shown_) return "null";
    frame = shown_;
    pixel = V2i(at(position.x, frame->size_px.x), at(position.y, frame->size_px.y));
    if (const std::vector<float>& rgba = displayed_->denoised; !rgba.empty()) {
      const size_t first =
          4 * (static_cast<size_t>(pixel.y) * static_cast<size_t>(frame->size_px.x) + static_cast<size_t>(pixel.x));
      denoised = Rgb(rgba[first], rgba[first + 1], rgba[first + 2]);
    }
  }
  std::optional<PickedSurface> picked;
  if (const std::shared_lock using_renderer(renderer_mutex_, std::try_to_lock); using_renderer.owns_lock())
    picked = renderer_->pick(position);
  return kindling::describe_pixel(*frame, pixel, denoised, picked ? &*picked : nullptr);
}

Result<std::string> ViewSession::describe_path(const V2f& position, uint32_t sample) const {
  const std::unique_lock tracing(path_mutex_, std::try_to_lock);
  if (!tracing.owns_lock()) return usage_error("another path is being traced");
  const std::shared_lock using_renderer(renderer_mutex_, std::try_to_lock);
  if (!using_renderer.owns_lock()) return usage_error("the scene is being loaded");
  const Result<ReplayedPath> path = renderer_->replay(position, sample);
  if (!path.ok()) return path.error();
  return kindling::describe_path(path.value());
}

Result<SavedFrame> ViewSession::save(FileKind kind) const {
  LinearFramePointer frame;
  std::vector<float> denoised;
  ViewState state;
  {
    const std::lock_guard lock(mutex_);
    frame = shown_;
    state = state_;
    if (displayed_) denoised = displayed_->denoised;
  }
  if (!frame) return usage_error("there is no image yet");
  const char* extension = kind == FileKind::png ? "png" : "exr";
  const std::string command =
      settings_.join(command_words(*frame, state, settings_.scene_file, settings_.passed_on, !denoised.empty()));
  const std::lock_guard lock(display_mutex_);
  Result<std::string> bytes = make_file(*frame, denoised, kind, display_.transform(), command);
  if (!bytes.ok()) return bytes.error();
  return SavedFrame{frame_file_name(*frame, settings_.scene_file, extension),
                    kind == FileKind::png ? "image/png" : "image/x-exr", std::move(bytes).value()};
}

void ViewSession::publish(const LinearFramePointer& frame, const DisplayedFrame* displayed) {
  const bool new_image = displayed != nullptr;
  const std::shared_ptr<const std::string> jpeg =
      new_image ? std::make_shared<const std::string>(displayed->jpeg) : nullptr;
  {
    const std::lock_guard lock(mutex_);
    auto sent = std::make_shared<SentFrame>();
    sent->version = sent_ ? sent_->version + 1 : 1;
    sent->image = new_image ? sent->version : sent_ ? sent_->image : 0;
    sent->jpeg = new_image ? jpeg : sent_ ? sent_->jpeg : nullptr;
    if (new_image) {
      displayed_ = *displayed;
      displayed_->jpeg.clear();
      shown_ = frame;
    }
    facts_.resident_bytes = resident_bytes();
    if (shown_)
      facts_.command = settings_.join(
          command_words(*shown_, state_, settings_.scene_file, settings_.passed_on, !displayed_->denoised.empty()));
    sent->header =
        header_json(state_, shown_.get(), displayed_ ? &*displayed_ : nullptr, facts_, sent->version, sent->image);
    sent_ = std::move(sent);
  }
  changed_.notify_all();
}

void ViewSession::set_status(const std::string& status) {
  {
    const std::lock_guard lock(mutex_);
    if (facts_.status == status) return;
    facts_.status = status;
  }
  publish(nullptr, nullptr);
}

void ViewSession::fail(const std::string& message) {
  if (settings_.on_warning) settings_.on_warning(message);
  {
    const std::lock_guard lock(mutex_);
    facts_.error = message;
    facts_.status = "failed";
  }
  publish(nullptr, nullptr);
}

} // namespace kindling
