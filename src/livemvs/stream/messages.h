#pragma once

/// What the records of the stream hold, apart from points (point_codec.h).

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "livemvs/core/camera.h"
#include "livemvs/core/point.h"
#include "livemvs/core/pose.h"

namespace livemvs {

/// Version of the stream; a reader refuses another.
inline constexpr std::uint32_t kStreamVersion = 1;

/// RecordType::kSession. The first record of a stream, and again each time a scan is resumed.
struct SessionMessage {
  std::uint32_t version = kStreamVersion;
  double unix_time = 0;  ///< When it began [s since 1970].
  std::string json;      ///< An object: what was asked for. Keys may be added at any time.
};

/// RecordType::kScene: the range in which surfaces are sought. [scene]
struct SceneMessage {
  std::optional<Box> box;
  double near = 0;
  double far = 0;
  std::string origin;  ///< For people: where it comes from.
};

/// RecordType::kFrame: comes before the points that converged in it.
struct FrameMessage {
  std::int64_t index = 0;
  double timestamp = 0;                   ///< [s] since the scan's first picture.
  std::uint8_t tracking_state = 0;        ///< 0 searching, 1 tracking, 2 lost, as TrackingState.
  std::optional<Rigid3d> cam_from_world;  ///< Without it the frame was not reconstructed from.
  std::uint32_t observations = 0;
  float rms_px = 0;
  float blur_px = 0;
};

enum class MessageLevel : std::uint8_t { kInfo = 0, kWarning = 1, kError = 2 };

/// RecordType::kMessage.
struct TextMessage {
  MessageLevel level = MessageLevel::kInfo;
  std::string text;
};

/// RecordType::kEnd.
struct EndMessage {
  enum Reason : std::uint8_t {
    kFinished = 0,     ///< The source came to its end, or the user said so.
    kInterrupted = 1,  ///< By the user, or because the camera did not come back.
    kFailed = 2,       ///< `text` says why.
  };
  Reason reason = kFinished;
  std::int64_t frames = 0;
  std::int64_t points = 0;
  std::string text;
};

std::vector<std::uint8_t> Encode(const SessionMessage& message);
std::vector<std::uint8_t> Encode(const Camera& camera);
std::vector<std::uint8_t> Encode(const SceneMessage& message);
std::vector<std::uint8_t> Encode(const FrameMessage& message);
std::vector<std::uint8_t> Encode(const TextMessage& message);
std::vector<std::uint8_t> Encode(const EndMessage& message);
/// RecordType::kStatistics: an object. See docs/data-formats.md for its keys.
std::vector<std::uint8_t> EncodeStatistics(const std::string& json);

/// Decoders answer with nothing where the payload is malformed: cut short, or a number not finite
/// or out of its range. Bytes that follow what is known are passed over, so that later versions may
/// append fields.
std::optional<SessionMessage> DecodeSession(std::span<const std::uint8_t> payload);
std::optional<Camera> DecodeCamera(std::span<const std::uint8_t> payload);
std::optional<SceneMessage> DecodeScene(std::span<const std::uint8_t> payload);
std::optional<FrameMessage> DecodeFrame(std::span<const std::uint8_t> payload);
std::optional<TextMessage> DecodeText(std::span<const std::uint8_t> payload);
std::optional<EndMessage> DecodeEnd(std::span<const std::uint8_t> payload);
std::optional<std::string> DecodeStatistics(std::span<const std::uint8_t> payload);

}  // namespace livemvs
