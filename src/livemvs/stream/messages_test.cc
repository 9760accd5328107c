#include "livemvs/stream/messages.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>

#include "livemvs/stream/bytes.h"

namespace livemvs {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

Camera SomeCamera() {
  Camera camera;
  camera.model = CameraModel::kBrownConrady;
  camera.width = 640;
  camera.height = 480;
  camera.fx = 500.25;
  camera.fy = 501.5;
  camera.cx = 319.5;
  camera.cy = 239.5;
  camera.distortion = {0.1, -0.2, 1e-3, -2e-3, 0.05, 0, 0, 0};
  return camera;
}

FrameMessage SomeFrame() {
  FrameMessage frame;
  frame.index = 123456789012;
  frame.timestamp = 3.25;
  frame.tracking_state = 1;
  frame.cam_from_world = {
      Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, -1).normalized()).toRotationMatrix(),
      {0.1, -0.2, 0.3}};
  frame.observations = 77;
  frame.rms_px = 0.04F;
  frame.blur_px = 1.5F;
  return frame;
}

// Decoders must refuse what is cut short and pass over what a later version may append.
template <typename Decode>
void ExpectCutsAreRefused(const Bytes& bytes, Decode decode) {
  for (std::size_t n = 0; n < bytes.size(); ++n) {
    EXPECT_FALSE(decode(ByteSpan(bytes).first(n)).has_value()) << n;
  }
  Bytes longer = bytes;
  longer.resize(bytes.size() + 8, 42);
  EXPECT_TRUE(decode(longer).has_value());
}

TEST(Messages, ASessionComesBack) {
  SessionMessage message;
  message.unix_time = 1.7e9;
  message.json = R"({"program":"livemvs"})";
  const auto back = DecodeSession(Encode(message));
  ASSERT_TRUE(back);
  EXPECT_EQ(back->version, kStreamVersion);
  EXPECT_EQ(back->unix_time, message.unix_time);
  EXPECT_EQ(back->json, message.json);
  ExpectCutsAreRefused(Encode(message), DecodeSession);
}

TEST(Messages, ACameraComesBack) {
  const Camera camera = SomeCamera();
  const auto back = DecodeCamera(Encode(camera));
  ASSERT_TRUE(back);
  EXPECT_EQ(back->model, camera.model);
  EXPECT_EQ(back->width, 640);
  EXPECT_EQ(back->height, 480);
  EXPECT_EQ(back->fx, camera.fx);
  EXPECT_EQ(back->cy, camera.cy);
  EXPECT_EQ(back->distortion, camera.distortion);
  ExpectCutsAreRefused(Encode(camera), DecodeCamera);
}

TEST(Messages, ASceneComesBackWithAndWithoutABox) {
  SceneMessage scene;
  scene.near = 0.25;
  scene.far = 2;
  scene.origin = "the board";
  EXPECT_FALSE(DecodeScene(Encode(scene))->box);
  scene.box = Box{{-1, -2, 0}, {1, 2, 0.5}};
  const auto back = DecodeScene(Encode(scene));
  ASSERT_TRUE(back && back->box);
  EXPECT_EQ(back->near, 0.25);
  EXPECT_EQ(back->far, 2);
  EXPECT_EQ(back->origin, "the board");
  EXPECT_EQ(back->box->min, scene.box->min);
  EXPECT_EQ(back->box->max, scene.box->max);
  ExpectCutsAreRefused(Encode(scene), DecodeScene);
}

TEST(Messages, AFrameComesBackWithAndWithoutAPose) {
  FrameMessage frame = SomeFrame();
  const auto back = DecodeFrame(Encode(frame));
  ASSERT_TRUE(back && back->cam_from_world);
  EXPECT_EQ(back->index, frame.index);
  EXPECT_EQ(back->timestamp, frame.timestamp);
  EXPECT_EQ(back->tracking_state, 1);
  EXPECT_EQ(back->observations, 77U);
  EXPECT_EQ(back->rms_px, frame.rms_px);
  EXPECT_EQ(back->blur_px, frame.blur_px);
  constexpr double kRounding = 1e-14;  // of the way through a quaternion
  EXPECT_LT((back->cam_from_world->rotation - frame.cam_from_world->rotation).norm(), kRounding);
  EXPECT_EQ(back->cam_from_world->translation, frame.cam_from_world->translation);
  ExpectCutsAreRefused(Encode(frame), DecodeFrame);
  frame.cam_from_world.reset();
  EXPECT_FALSE(DecodeFrame(Encode(frame))->cam_from_world);
}

TEST(Messages, TextsStatisticsAndTheEndComeBack) {
  const auto text = DecodeText(Encode(TextMessage{MessageLevel::kWarning, "slow down"}));
  ASSERT_TRUE(text);
  EXPECT_EQ(text->level, MessageLevel::kWarning);
  EXPECT_EQ(text->text, "slow down");
  EXPECT_EQ(DecodeStatistics(EncodeStatistics("{}")), "{}");
  const auto end = DecodeEnd(Encode(EndMessage{EndMessage::kFailed, 10, 2000, "disk full"}));
  ASSERT_TRUE(end);
  EXPECT_EQ(end->reason, EndMessage::kFailed);
  EXPECT_EQ(end->frames, 10);
  EXPECT_EQ(end->points, 2000);
  EXPECT_EQ(end->text, "disk full");
  ExpectCutsAreRefused(Encode(EndMessage{}), DecodeEnd);
}

TEST(Messages, NumbersThatCannotBeAreRefused) {
  FrameMessage frame = SomeFrame();
  frame.cam_from_world->translation.x() = kNaN;
  EXPECT_FALSE(DecodeFrame(Encode(frame)));
  frame = SomeFrame();
  frame.cam_from_world->rotation *= 2;
  EXPECT_FALSE(DecodeFrame(Encode(frame)));
  frame = SomeFrame();
  frame.index = -1;
  EXPECT_FALSE(DecodeFrame(Encode(frame)));
  frame = SomeFrame();
  frame.tracking_state = 3;
  EXPECT_FALSE(DecodeFrame(Encode(frame)));
  Camera camera = SomeCamera();
  camera.fx = 0;
  EXPECT_FALSE(DecodeCamera(Encode(camera)));
  camera = SomeCamera();
  camera.distortion[2] = kNaN;
  EXPECT_FALSE(DecodeCamera(Encode(camera)));
  SceneMessage scene;
  scene.near = 2;
  scene.far = 1;
  EXPECT_FALSE(DecodeScene(Encode(scene)));
  scene.far = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(DecodeScene(Encode(scene)));
}

TEST(Messages, ATextLongerThanItsRecordIsRefused) {
  Bytes bytes = Encode(TextMessage{MessageLevel::kInfo, "abc"});
  bytes[4] = 200;
  EXPECT_FALSE(DecodeText(bytes));
  bytes[7] = 255;
  EXPECT_FALSE(DecodeText(bytes));
}

}  // namespace
}  // namespace livemvs
