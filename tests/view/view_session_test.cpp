// A view renders, follows changes, and ends, without a server.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/view/view_session.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <chrono>
#include <functional>
#include <numeric>

namespace kindling {
namespace {

using nlohmann::json;

class Silent final : public ProgressListener {
 public:
  void on_progress(const ProgressSnapshot&) override {}
  void on_warning(std::string_view) override {}
  void on_info(std::string_view) override {}
};

ViewSession::Settings small_settings(uint32_t spp) {
  ViewSession::Settings settings;
  settings.scene_file = std::string(KINDLING_SCENES) + "/cornell_box.glb";
  settings.options.image.size_px = V2i(64, 48);
  settings.options.image.spp = spp;
  settings.join = [](const std::vector<std::string>& words) {
    return std::accumulate(words.begin(), words.end(), std::string(),
                           [](std::string line, const std::string& word) { return std::move(line) + " " + word; });
  };
  return settings;
}

std::unique_ptr<ViewSession> open_session(ViewSession::Settings settings) {
  Silent listener;
  Result<std::unique_ptr<ViewSession>> session = ViewSession::open(std::move(settings), listener);
  EXPECT_TRUE(session.ok()) << (session.ok() ? "" : session.error().message);
  return std::move(session).value();
}

// The first frame that meets a condition.
json wait_for(ViewSession& session, const std::function<bool(const json&)>& condition) {
  uint64_t version = 0;
  for (int i = 0; i < 2000; ++i) {
    const std::shared_ptr<const SentFrame> frame = session.wait_for_frame(version, 5.0);
    if (!frame) continue;
    version = frame->version;
    json header = json::parse(frame->header);
    if (condition(header)) return header;
  }
  ADD_FAILURE() << "no such frame";
  return {};
}

bool is_complete(const json& header) {
  return header["status"] == "complete" && header["frame"]["complete"] == true && header["frame"]["moving"] == false;
}

TEST(ViewSession, FirstAQuickImageThenAllSamples) {
  const auto session = open_session(small_settings(32));
  session->start();
  const json first = wait_for(*session, [](const json& header) { return header.contains("frame"); });
  EXPECT_TRUE(first["frame"]["moving"] == true || first["frame"]["samples"].get<int>() > 0);
  const json last = wait_for(*session, is_complete);
  EXPECT_EQ(last["frame"]["samples"], 32);
  EXPECT_EQ(last["frame"]["size"], json({64, 48}));
  EXPECT_NE(last["command"].get<std::string>().find("--spp 32 --planned-spp 32"), std::string::npos);
}

TEST(ViewSession, DisplayChangesRenderNothing) {
  const auto session = open_session(small_settings(4));
  session->start();
  const json before = wait_for(*session, is_complete);
  ASSERT_TRUE(session->change(R"({"exposure":2})").ok());
  const json after = wait_for(*session, [&](const json& header) { return header["image"] > before["image"]; });
  EXPECT_EQ(after["status"], "complete");
  EXPECT_EQ(after["frame"]["samples"], 4);
  EXPECT_EQ(after["state"]["exposure"], 2.0);
}

TEST(ViewSession, MotionEndsARender) {
  const auto session = open_session(small_settings(1U << 16));
  session->start();
  wait_for(*session, [](const json& header) { return header.contains("frame") && header["frame"]["moving"] == false; });
  const auto start = std::chrono::steady_clock::now();
  ASSERT_TRUE(session->change(R"({"orbit":[20,70,3]})").ok());
  wait_for(*session, [](const json& header) {
    return header["frame"]["moving"] == true && header["state"]["orbit"] == json({20.0, 70.0, 3.0});
  });
  EXPECT_LT(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(), 5.0);
}

TEST(ViewSession, StopsInTheMiddleOfARender) {
  const auto session = open_session(small_settings(1U << 16));
  session->start();
  wait_for(*session, [](const json& header) { return header["status"] == "rendering"; });
  const auto start = std::chrono::steady_clock::now();
  session->stop();
  EXPECT_LT(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(), 2.0);
  EXPECT_FALSE(session->wait_for_frame(1U << 30, 0.0));
}

TEST(ViewSession, ImpossibleSettingsAreReported) {
  const auto session = open_session(small_settings(4));
  session->start();
  wait_for(*session, is_complete);
  ASSERT_TRUE(session->change(R"({"camera":"no such camera"})").ok());
  const json failed = wait_for(*session, [](const json& header) { return header["error"] != ""; });
  EXPECT_NE(failed["error"].get<std::string>().find("no such camera"), std::string::npos);
  EXPECT_FALSE(session->change(R"({"camera":1})").ok());
  ASSERT_TRUE(session->change(R"({"camera":""})").ok());
  wait_for(*session, [](const json& header) { return header["error"] == "" && is_complete(header); });
}

TEST(ViewSession, SavesTheDisplayedImage) {
  const auto session = open_session(small_settings(4));
  EXPECT_FALSE(session->save(FileKind::png).ok()) << "before the first image";
  session->start();
  wait_for(*session, is_complete);
  const Result<SavedFrame> png = session->save(FileKind::png), exr = session->save(FileKind::exr);
  ASSERT_TRUE(png.ok() && exr.ok());
  EXPECT_EQ(png.value().file_name, "cornell_box-4spp.png");
  EXPECT_EQ(png.value().bytes.substr(1, 3), "PNG");
  EXPECT_EQ(exr.value().bytes.substr(0, 4), "\x76\x2f\x31\x01");
}

TEST(ViewSession, MissingScenesAndViewsFail) {
  Silent listener;
  ViewSession::Settings settings = small_settings(1);
  settings.options.display_view = "no such view";
  EXPECT_FALSE(ViewSession::open(settings, listener).ok());
  settings = small_settings(1);
  settings.scene_file = "missing.glb";
  EXPECT_FALSE(ViewSession::open(settings, listener).ok());
}

} // namespace
} // namespace kindling
