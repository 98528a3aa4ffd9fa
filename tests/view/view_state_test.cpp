// Changes of a view's state as JSON, and the settings that follow.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/view/view_state.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace kindling {
namespace {

ViewState state_after(const std::string& text, ViewState state = {}) {
  const Result<void> applied = apply_json(text, state);
  EXPECT_TRUE(applied.ok()) << (applied.ok() ? "" : applied.error().message);
  return state;
}

TEST(ViewState, EveryMemberIsReadAndWritten) {
  const std::string all =
      R"({"camera":"Left","orbit":[10.5,80,2.25],"target":[1,2,3],"roll":-12.5,"orthographic":3.5,"fov":33.5,"f_stop":2.8,"focus":1.5,
    "time":0.25,"size":[320,180],"spp":37,"guiding":false,"shown":"depth","scene":"1","variant":"red","view":"AgX",
    "exposure":-1.5,"false_color":true,"denoise":true})";
  const ViewState state = state_after(all);
  EXPECT_EQ(state.camera.orbit, V3f(10.5f, 80.0f, 2.25f));
  EXPECT_EQ(state.size_px, V2i(320, 180));
  EXPECT_EQ(state.shown, Aov::depth);
  EXPECT_EQ(nlohmann::json::parse(to_json(state)), nlohmann::json::parse(all));
  EXPECT_EQ(state_after(to_json(state)), state);
  EXPECT_EQ(state_after(to_json(ViewState{.size_px = V2i(64, 64)})), (ViewState{.size_px = V2i(64, 64)})); // nulls
}

TEST(ViewState, WrongMembersChangeNothing) {
  const ViewState before = state_after(R"({"size":[64,48]})");
  for (const char* text : {"",
                           "[]",
                           "1",
                           "{",
                           R"({"x":1})",
                           R"({"orbit":[0,0,-1]})",
                           R"({"orbit":[0,0]})",
                           R"({"orbit":"0,0,1"})",
                           R"({"target":[0,0,1e30]})",
                           R"({"fov":0})",
                           R"({"roll":null})",
                           R"({"roll":361})",
                           R"({"orthographic":0})",
                           R"({"fov":true})",
                           R"({"size":[15,64]})",
                           R"({"size":[64,4097]})",
                           R"({"spp":0})",
                           R"({"spp":65537})",
                           R"({"guiding":1})",
                           R"({"shown":"beautiful"})",
                           R"({"shown":"shadow_catcher"})",
                           R"({"exposure":null})",
                           R"({"exposure":1e9})",
                           R"({"variant":7})",
                           R"({"exposure":1,"camera":[[[[[]]]]]})"}) {
    ViewState state = before;
    EXPECT_FALSE(apply_json(text, state).ok()) << text;
    EXPECT_EQ(state, before) << text;
  }
  ViewState state = before;
  EXPECT_FALSE(apply_json(R"({"camera":")" + std::string(300, 'x') + R"("})", state).ok());
  EXPECT_FALSE(apply_json(R"({"exposure":1,"unknown":1})", state).ok()); // the good one before it neither
  EXPECT_EQ(state, before);
}

TEST(ViewState, ChangesHaveTheirExtent) {
  const ViewState state = state_after(R"({"size":[64,48]})");
  EXPECT_EQ(compare(state, state), ViewChange::none);
  for (const char* text : {R"({"exposure":1})", R"({"view":"AgX"})", R"({"false_color":true})", R"({"denoise":true})"})
    EXPECT_EQ(compare(state, state_after(text, state)), ViewChange::display) << text;
  for (const char* text : {R"({"spp":5})", R"({"size":[64,64]})", R"({"shown":"normal"})", R"({"guiding":false})"})
    EXPECT_EQ(compare(state, state_after(text, state)), ViewChange::image) << text;
  for (const char* text : {R"({"orbit":[0,90,1]})", R"({"roll":5})", R"({"orthographic":5})", R"({"time":1})",
                           R"({"camera":"1"})", R"({"focus":1})"})
    EXPECT_EQ(compare(state, state_after(text, state)), ViewChange::motion) << text;
  for (const char* text : {R"({"variant":"red"})", R"({"scene":"1"})"})
    EXPECT_EQ(compare(state, state_after(text, state)), ViewChange::world) << text;
}

TEST(ViewState, OptionsAreDefaults) {
  ViewOptions options;
  options.image.camera = "Left";
  options.image.lens.pinhole = true;
  options.image.guiding = Guiding::on;
  options.image.seed = 9;
  const ViewState state = initial_state(options);
  EXPECT_EQ(state.camera.name, "Left");
  EXPECT_EQ(state.camera.f_stop, 0.0);
  const ImageSettings image = image_settings(state, options);
  EXPECT_TRUE(image.lens.pinhole);
  EXPECT_EQ(image.guiding, Guiding::on);
  EXPECT_EQ(image.seed, 9U);
  EXPECT_EQ(image.planned_spp, image.spp);
  ViewState moved = state;
  moved.camera.orbit = V3f(0.0f, 90.0f, 1.0f);
  EXPECT_EQ(image_settings(moved, options).camera, "") << "an orbit replaces the camera";
}

TEST(ViewState, RollAndHeightAreOfOrbits) {
  const ViewState state = state_after(R"({"size":[64,48],"roll":30,"orthographic":4,"fov":50})");
  const ImageSettings still = image_settings(state, {});
  EXPECT_FALSE(still.turn.has_value());
  EXPECT_FALSE(still.orthographic_m.has_value());
  EXPECT_EQ(still.yfov_deg, 50.0);
  const ImageSettings moved = image_settings(state_after(R"({"orbit":[90,90,2],"target":[1,2,3]})", state), {});
  ASSERT_TRUE(moved.turn.has_value());
  EXPECT_EQ(moved.turn->angle_deg, 30.0);
  EXPECT_LT((moved.turn->axis - V3f(1, 0, 0)).length(), 1e-6f) << "from the target to the eye";
  EXPECT_EQ(moved.turn->around, V3f(1, 2, 3));
  EXPECT_EQ(moved.orthographic_m, 4.0);
  EXPECT_FALSE(moved.yfov_deg.has_value()) << "an image without perspective has no field of view";
}

TEST(ViewState, FocusNeedsALens) {
  const ViewState state = state_after(R"({"size":[64,48],"focus":2})");
  EXPECT_FALSE(image_settings(state, {}).lens.focus_distance_m);
  const ViewState lens = state_after(R"({"f_stop":2})", state);
  EXPECT_EQ(image_settings(lens, {}).lens.focus_distance_m, 2.0);
  EXPECT_FALSE(image_settings(state_after(R"({"f_stop":0})", lens), {}).lens.focus_distance_m);
}

// Images of the first samples are denoised, too. Pixels that share paths would have stains then.
TEST(ViewState, DenoisedImagesShareNoPaths) {
  const ViewState noisy = state_after(R"({"size":[64,48]})");
  const ViewState denoised = state_after(R"({"denoise":true})", noisy);
  EXPECT_TRUE(image_settings(noisy, {}).chooses_path_reuse);
  EXPECT_FALSE(image_settings(denoised, {}).chooses_path_reuse);
  EXPECT_EQ(image_settings(denoised, {}).integrator.path_reuse, 1);
  ViewOptions options;
  options.image.chooses_path_reuse = false;
  options.image.integrator.path_reuse = 4;
  EXPECT_EQ(image_settings(denoised, options).integrator.path_reuse, 4) << "as was asked for";
}

TEST(ViewState, MovingImagesFitTheirTime) {
  const ViewState state = state_after(R"({"size":[640,360],"denoise":true})");
  for (const double paths : {1.0, 3600.0, 57600.0, 230400.0, 1e6, 1e9}) {
    const ImageSettings image = moving_settings(state, {}, paths, 3);
    const double taken = static_cast<double>(image.size_px->x) * image.size_px->y * *image.spp;
    EXPECT_LE(taken, std::max(paths * 1.02, 40.0 * 23)) << paths; // not below a 16th of a side
    EXPECT_NEAR(static_cast<double>(image.size_px->x) / image.size_px->y, 16.0 / 9.0, 0.05);
    EXPECT_LE(image.size_px->x, 640);
    EXPECT_LE(*image.spp, 16U);
    EXPECT_EQ(image.guiding, Guiding::off);
    EXPECT_EQ(image.denoising, Denoising::off);
    EXPECT_EQ(image.seed, 3U);
  }
}

} // namespace
} // namespace kindling
