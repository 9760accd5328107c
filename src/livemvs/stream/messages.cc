#include "livemvs/stream/messages.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "livemvs/stream/bytes.h"

namespace livemvs {
namespace {

// Beyond these, indices and counts are damage; they are exact in a double, as pages need them.
constexpr std::int64_t kMaxCount = std::int64_t{1} << 53;
constexpr double kQuaternionTolerance = 1e-6;

bool IsCount(std::int64_t value) { return value >= 0 && value <= kMaxCount; }

void PutPose(const Rigid3d& pose, ByteWriter* out) {
  const Eigen::Quaterniond q(pose.rotation);
  for (const double v : {q.w(), q.x(), q.y(), q.z()}) out->Put(v);
  for (int i = 0; i < 3; ++i) out->Put(pose.translation[i]);
}

std::optional<Rigid3d> GetPose(ByteReader* in) {
  std::array<double, 7> v{};
  for (double& x : v) x = in->Get<double>();
  const Eigen::Quaterniond q(v[0], v[1], v[2], v[3]);
  const bool finite = std::all_of(v.begin(), v.end(), [](double x) { return std::isfinite(x); });
  if (!finite || std::abs(q.norm() - 1) > kQuaternionTolerance) return std::nullopt;
  return Rigid3d{q.normalized().toRotationMatrix(), {v[4], v[5], v[6]}};
}

}  // namespace

Bytes Encode(const SessionMessage& message) {
  Bytes bytes;
  ByteWriter out(&bytes);
  out.Put(message.version);
  out.Put(std::uint32_t{0});
  out.Put(message.unix_time);
  out.PutText(message.json);
  return bytes;
}

std::optional<SessionMessage> DecodeSession(ByteSpan payload) {
  ByteReader in(payload);
  SessionMessage message;
  message.version = in.Get<std::uint32_t>();
  in.Get<std::uint32_t>();
  message.unix_time = in.Get<double>();
  message.json = in.GetText();
  if (!in.ok() || !std::isfinite(message.unix_time)) return std::nullopt;
  return message;
}

Bytes Encode(const Camera& camera) {
  Bytes bytes;
  ByteWriter out(&bytes);
  out.Put(static_cast<std::uint32_t>(camera.model));
  out.Put(static_cast<std::uint32_t>(camera.width));
  out.Put(static_cast<std::uint32_t>(camera.height));
  out.Put(std::uint32_t{0});
  for (const double v : {camera.fx, camera.fy, camera.cx, camera.cy}) out.Put(v);
  for (const double k : camera.distortion) out.Put(k);
  return bytes;
}

std::optional<Camera> DecodeCamera(ByteSpan payload) {
  ByteReader in(payload);
  Camera camera;
  const auto model = in.Get<std::uint32_t>();
  const auto width = in.Get<std::uint32_t>();
  const auto height = in.Get<std::uint32_t>();
  in.Get<std::uint32_t>();
  for (double* v : {&camera.fx, &camera.fy, &camera.cx, &camera.cy}) *v = in.Get<double>();
  for (double& k : camera.distortion) k = in.Get<double>();
  constexpr std::uint32_t kMaxSide = 32768;
  const auto last_model = static_cast<std::uint32_t>(CameraModel::kKannalaBrandt);
  if (!in.ok() || model > last_model || width > kMaxSide || height > kMaxSide) return std::nullopt;
  camera.model = static_cast<CameraModel>(model);
  camera.width = static_cast<int>(width);
  camera.height = static_cast<int>(height);
  try {
    camera.Check();
  } catch (const std::invalid_argument&) {
    return std::nullopt;
  }
  return camera;
}

Bytes Encode(const SceneMessage& message) {
  Bytes bytes;
  ByteWriter out(&bytes);
  const Box box = message.box.value_or(Box{});
  out.Put(static_cast<std::uint32_t>(message.box.has_value()));
  out.Put(std::uint32_t{0});
  out.Put(message.near);
  out.Put(message.far);
  for (int i = 0; i < 3; ++i) out.Put(box.min[i]);
  for (int i = 0; i < 3; ++i) out.Put(box.max[i]);
  out.PutText(message.origin);
  return bytes;
}

std::optional<SceneMessage> DecodeScene(ByteSpan payload) {
  ByteReader in(payload);
  SceneMessage message;
  const auto has_box = in.Get<std::uint32_t>();
  in.Get<std::uint32_t>();
  message.near = in.Get<double>();
  message.far = in.Get<double>();
  Box box;
  for (int i = 0; i < 3; ++i) box.min[i] = in.Get<double>();
  for (int i = 0; i < 3; ++i) box.max[i] = in.Get<double>();
  message.origin = in.GetText();
  const bool ordered = (box.min.array() <= box.max.array()).all();
  if (!in.ok() || !(message.near > 0 && message.near < message.far) ||
      !std::isfinite(message.far) || !box.min.allFinite() || !box.max.allFinite() || !ordered ||
      has_box > 1) {
    return std::nullopt;
  }
  if (has_box == 1) message.box = box;
  return message;
}

Bytes Encode(const FrameMessage& message) {
  Bytes bytes;
  ByteWriter out(&bytes);
  out.Put(message.index);
  out.Put(message.timestamp);
  out.Put(message.tracking_state);
  out.Put(static_cast<std::uint8_t>(message.cam_from_world.has_value()));
  out.Put(std::uint16_t{0});
  out.Put(message.observations);
  out.Put(message.rms_px);
  out.Put(message.blur_px);
  PutPose(message.cam_from_world.value_or(Rigid3d{}), &out);
  return bytes;
}

std::optional<FrameMessage> DecodeFrame(ByteSpan payload) {
  ByteReader in(payload);
  FrameMessage message;
  message.index = in.Get<std::int64_t>();
  message.timestamp = in.Get<double>();
  message.tracking_state = in.Get<std::uint8_t>();
  const auto has_pose = in.Get<std::uint8_t>();
  in.Get<std::uint16_t>();
  message.observations = in.Get<std::uint32_t>();
  message.rms_px = in.Get<float>();
  message.blur_px = in.Get<float>();
  const std::optional<Rigid3d> pose = GetPose(&in);
  if (!in.ok() || !IsCount(message.index) || !std::isfinite(message.timestamp) ||
      message.tracking_state > 2 || has_pose > 1 || !pose || !std::isfinite(message.rms_px) ||
      !std::isfinite(message.blur_px)) {
    return std::nullopt;
  }
  if (has_pose == 1) message.cam_from_world = pose;
  return message;
}

Bytes Encode(const TextMessage& message) {
  Bytes bytes;
  ByteWriter out(&bytes);
  out.Put(static_cast<std::uint32_t>(message.level));
  out.PutText(message.text);
  return bytes;
}

std::optional<TextMessage> DecodeText(ByteSpan payload) {
  ByteReader in(payload);
  const auto level = in.Get<std::uint32_t>();
  TextMessage message;
  message.text = in.GetText();
  if (!in.ok() || level > static_cast<std::uint32_t>(MessageLevel::kError)) return std::nullopt;
  message.level = static_cast<MessageLevel>(level);
  return message;
}

Bytes Encode(const EndMessage& message) {
  Bytes bytes;
  ByteWriter out(&bytes);
  out.Put(static_cast<std::uint32_t>(message.reason));
  out.Put(std::uint32_t{0});
  out.Put(message.frames);
  out.Put(message.points);
  out.PutText(message.text);
  return bytes;
}

std::optional<EndMessage> DecodeEnd(ByteSpan payload) {
  ByteReader in(payload);
  EndMessage message;
  const auto reason = in.Get<std::uint32_t>();
  in.Get<std::uint32_t>();
  message.frames = in.Get<std::int64_t>();
  message.points = in.Get<std::int64_t>();
  message.text = in.GetText();
  if (!in.ok() || reason > EndMessage::kFailed || !IsCount(message.frames) ||
      !IsCount(message.points)) {
    return std::nullopt;
  }
  message.reason = static_cast<EndMessage::Reason>(reason);
  return message;
}

Bytes EncodeStatistics(const std::string& json) {
  Bytes bytes;
  ByteWriter(&bytes).PutText(json);
  return bytes;
}

std::optional<std::string> DecodeStatistics(ByteSpan payload) {
  ByteReader in(payload);
  std::string json = in.GetText();
  if (!in.ok()) return std::nullopt;
  return json;
}

}  // namespace livemvs
