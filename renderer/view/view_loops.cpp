// The threads of a view: one renders, one displays, one watches the files of the scene.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/view/view_session.h"

#include "renderer/scene/strokes.h"

#include <algorithm>
#include <system_error>
#include <utility>

namespace kindling {

namespace {

constexpr std::chrono::milliseconds kSettle(200);    // without a change, until the whole image is rendered
constexpr double kMovingFrameS = 0.05;               // aim for the time of a quick image
constexpr double kFirstMovingFrameS = 0.03;          // and of the first one after a rest, which answers an input
constexpr std::chrono::milliseconds kWatchStep(500); // between looks at files

using FileTimes = std::vector<std::pair<std::filesystem::file_time_type, uintmax_t>>;

FileTimes times_of(const std::vector<std::filesystem::path>& files) {
  FileTimes times;
  for (const std::filesystem::path& file : files) {
    std::error_code no_time, no_size;
    const auto time = std::filesystem::last_write_time(file, no_time);
    const uintmax_t size = std::filesystem::file_size(file, no_size);
    times.emplace_back(no_time ? std::filesystem::file_time_type{} : time, no_size ? 0 : size);
  }
  return times;
}

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

} // namespace

// Waits for something to do.
ViewSession::Task ViewSession::next_task(ViewState& state, uint64_t& revision) {
  std::unique_lock lock(mutex_);
  for (;;) {
    if (stopping_) return Task::stop;
    state = state_;
    revision = revision_;
    if (must_load_) {
      must_load_ = false;
      return Task::load;
    }
    if (moved_ != revision_) return Task::moving;
    if (whole_ != revision_) {
      const Clock::time_point due = last_change_ + kSettle;
      if (Clock::now() >= due) return Task::whole;
      changed_.wait_until(lock, due);
    } else {
      changed_.wait(lock);
    }
  }
}

void ViewSession::describe() {
  has_strokes_ = has_strokes(renderer_->scene());
  const Result<std::vector<std::string>> views = DisplayTransform::list_views(settings_.options.ocio_config);
  std::string description = describe_scene(*renderer_, settings_.scene_file.filename().string(),
                                           views.ok() ? views.value() : std::vector<std::string>());
  const std::lock_guard lock(mutex_);
  description_ = std::move(description);
  ++facts_.scene;
}

void ViewSession::render_loop() {
  describe();
  for (;;) {
    ViewState state;
    uint64_t revision = 0;
    switch (next_task(state, revision)) {
    case Task::stop: return;
    case Task::load: load(state); break;
    case Task::moving: render_moving(state, revision); break;
    case Task::whole: render_whole(state, revision); break;
    }
  }
}

// Replaces the Renderer by one with the files as they are now. If that fails the old one remains.
bool ViewSession::replace_renderer(const ViewState& state) {
  set_status("loading");
  RunOptions run;
  run.threads = settings_.options.threads;
  run.on_warning = settings_.on_warning;
  const auto load_start = std::filesystem::file_time_type::clock::now();
  Result<Renderer> loaded = Renderer::load(settings_.scene_file, world_settings(state, settings_.options), run);
  if (!loaded.ok()) {
    fail(loaded.error().message);
    return false;
  }
  {
    const std::lock_guard lock(mutex_);
    watched_ = watched_files(loaded.value(), load_start);
  }
  {
    const std::unique_lock replacing(renderer_mutex_);
    renderer_.emplace(std::move(loaded).value());
  }
  describe();
  decided_ = false;
  first_image_.reset();
  return true;
}

void ViewSession::load(const ViewState& state) {
  if (!replace_renderer(state)) return;
  const std::lock_guard lock(mutex_);
  facts_.error.clear();
  ++revision_;
}

CameraSeen ViewSession::camera_seen(const PlacedCamera& camera) const {
  const M44f& m = camera.camera_to_world;
  const V3f eye(m[3][0], m[3][1], m[3][2]);
  const Box3f bounds = renderer_->bounds();
  const float size = std::max(bounds.size().length(), 1e-6f);
  const float to_center = -(bounds.center() - eye).dot(V3f(m[2][0], m[2][1], m[2][2]).normalized());
  float distance = to_center;
  if (bounds.intersects(eye) || to_center < 0.05f * size) {
    const std::optional<PickedSurface> seen = renderer_->pick(V2f(0.5f));
    distance = seen && seen->depth_m > 0.0f ? seen->depth_m : 0.25f * size;
  }
  return as_orbit(camera, distance);
}

void ViewSession::show(LinearFrame frame) {
  auto shared = std::make_shared<const LinearFrame>(std::move(frame));
  {
    const std::lock_guard lock(mutex_);
    latest_ = std::move(shared);
    ++display_wanted_;
  }
  changed_.notify_all();
}

std::optional<double> ViewSession::render(const ViewState& state, const ImageSettings& image, const CancelToken& cancel,
                                          bool moving) {
  const Clock::time_point start = Clock::now();
  Clock::time_point rendering = start;
  RunOptions run;
  run.threads = settings_.options.threads;
  run.cancel = &cancel;
  run.keep_decisions = std::exchange(decided_, true);
  if (!first_image_) first_image_.emplace(state.camera, *image.size_px);
  if (!run.keep_decisions) run.on_warning = settings_.on_warning;
  run.on_progress = [&](const ProgressSnapshot& progress) {
    if (progress.phase == Phase::render) {
      const std::lock_guard lock(mutex_);
      facts_.rays_per_s = static_cast<double>(progress.rays) / std::max(seconds_since(rendering), 1e-3);
    } else {
      set_status("building");
      rendering = Clock::now();
    }
  };
  run.on_pass = [&](const Film& film) {
    LinearFrame frame = make_linear_frame(film, state);
    frame.image = image;
    frame.image.spp = static_cast<uint32_t>(film.total_samples() / static_cast<uint64_t>(film.crop().pixel_count()));
    frame.world = world_settings(state, settings_.options);
    const DecidedSettings decided = renderer_->decided();
    if (frame.image.backfaces == Backfaces::automatic) frame.image.backfaces = decided.backfaces;
    if (frame.world.studio == Studio::automatic) frame.world.studio = decided.studio;
    frame.moving = moving;
    frame.complete = frame.image.spp == image.spp;
    frame.render_s = seconds_since(start);
    show(std::move(frame));
  };
  const Result<RenderedImage> rendered = renderer_->render(image, run);
  if (!rendered.ok()) {
    fail(rendered.error().message);
    return std::nullopt;
  }
  const RenderStatistics& statistics = rendered.value().statistics;
  const CameraSeen camera = camera_seen(rendered.value().camera);
  {
    const std::lock_guard lock(mutex_);
    facts_.camera = camera;
    if (statistics.render_s > 0.0)
      facts_.rays_per_s = static_cast<double>(statistics.rays.total()) / statistics.render_s;
  }
  return rendered.value().interrupted ? std::nullopt : std::optional(seconds_since(start));
}

void ViewSession::render_moving(const ViewState& state, uint64_t revision) {
  const CancelToken never;
  const bool first = !decided_;
  const double aim_s = Clock::now() - last_moving_ < kSettle ? kMovingFrameS : kFirstMovingFrameS;
  const ImageSettings image = moving_settings(state, settings_.options, paths_per_s_ * aim_s, ++moving_frames_);
  const std::optional<double> took_s = render(state, image, never, true);
  last_moving_ = Clock::now();
  if (took_s && !first) { // the first one builds the World
    const double paths = static_cast<double>(image.size_px->x) * image.size_px->y * *image.spp;
    paths_per_s_ += 0.4 * (paths / std::max(*took_s, 1e-3) - paths_per_s_);
  }
  const std::lock_guard lock(mutex_);
  moved_ = revision;
  if (!took_s) whole_ = revision; // it would fail likewise
}

void ViewSession::render_whole(const ViewState& state, uint64_t revision) {
  const auto cancel = std::make_shared<CancelToken>();
  {
    const std::lock_guard lock(mutex_);
    if (stopping_ || revision != revision_) return;
    cancel_ = cancel;
  }
  // Points and lines have the width that they get from the first image of a Renderer.
  const bool other_widths = has_strokes_ && first_image_ && *first_image_ != std::pair(state.camera, state.size_px);
  std::optional<double> took_s;
  if (!other_widths || replace_renderer(state)) {
    set_status("rendering");
    took_s = render(state, image_settings(state, settings_.options), *cancel, false);
  }
  {
    const std::lock_guard lock(mutex_);
    cancel_.reset();
    whole_ = revision;
  }
  if (took_s) set_status("complete");
}

void ViewSession::display_loop() {
  for (;;) {
    LinearFramePointer frame;
    ViewState state;
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [&] { return stopping_ || display_wanted_ != display_done_; });
      if (stopping_) return;
      display_done_ = display_wanted_;
      frame = latest_;
      state = state_;
    }
    if (!frame) continue;
    const std::lock_guard displaying(display_mutex_);
    const Result<void> chosen =
        display_.choose(state.display_view, state.exposure_stops, settings_.options.ocio_config);
    const bool denoises = state.denoise && !frame->moving;
    if (denoises && !denoiser_) denoiser_.emplace(Denoiser::open(settings_.options.threads));
    const Denoiser* denoiser = denoises && denoiser_->ok() ? &denoiser_->value() : nullptr;
    if (denoises && !denoiser_->ok()) {
      {
        const std::lock_guard lock(mutex_);
        state_.denoise = false;
        ++revision_;
        ++display_wanted_;
      }
      fail(denoiser_->error().message);
      continue;
    }
    if (!chosen.ok()) {
      fail(chosen.error().message);
      continue;
    }
    const Result<DisplayedFrame> displayed = display_.display(*frame, state, denoiser);
    if (displayed.ok())
      publish(frame, &displayed.value());
    else
      fail(displayed.error().message);
  }
}

ViewSession::WatchedFiles ViewSession::watched_files(const Renderer& renderer,
                                                     std::filesystem::file_time_type load_start) {
  WatchedFiles files{renderer.inputs(), {}};
  files.times = times_of(files.names);
  for (auto& [time, size] : files.times)
    if (time >= load_start) time = {};
  return files;
}

// Loads the scene again when its files have changed and then rested for one step.
void ViewSession::watch_loop() {
  FileTimes last;
  for (std::unique_lock lock(mutex_); !stopping_;) {
    changed_.wait_for(lock, kWatchStep, [this] { return stopping_; });
    const std::vector<std::filesystem::path> names = watched_.names;
    lock.unlock();
    FileTimes now = times_of(names);
    lock.lock();
    const bool rests = now == last;
    last = std::move(now);
    if (!rests || names != watched_.names || last == watched_.times) continue;
    watched_.times = last; // once, also if loading fails
    must_load_ = true;
    if (cancel_) cancel_->cancel_now();
    changed_.notify_all();
  }
}

} // namespace kindling
