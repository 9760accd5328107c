#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "livemvs/backend/seed_state.h"
#include "livemvs/core/image.h"
#include "livemvs/core/options.h"
#include "livemvs/core/point.h"
#include "livemvs/core/posed_camera.h"
#include "livemvs/core/scene_range.h"

namespace livemvs {

/// Consecutive seeds [begin, end) that were born in the same frame at the same level of its
/// pyramid, and how it lies to the current one.
struct SeedGroup {
  std::size_t begin;
  std::size_t end;
  int level;                 ///< Of the pyramid: the image that the seeds meet.
  RelativeView<float> view;  ///< Both cameras at that level.
  float pixel_width;         ///< 1 / f of the reference camera at that level.
};

/// Where step 1 plants seeds, and what is known there already.
struct Planting {
  PosedCamera frame;  ///< The current frame's, at level 0.
  const SceneRange* range;
  std::span<const SeedGroup> groups;  ///< The seeds that there are, as they lie to the frame.
  /// Those of the last planting, and new ones after them; see Backend::ForgetPoints().
  std::span<const Point> points;
};

/// What one update did, by the status of the match and the fate that followed.
struct UpdateStatistics {
  std::int64_t matched = 0;
  std::int64_t no_information = 0;
  std::int64_t out_of_view = 0;
  std::int64_t mismatched = 0;

  /// Updates of the posterior and frames that were looked at, with or without a result.
  std::int64_t total() const { return matched + no_information + out_of_view + mismatched; }

  UpdateStatistics& operator+=(const UpdateStatistics& other) {
    matched += other.matched;
    no_information += other.no_information;
    out_of_view += other.out_of_view;
    mismatched += other.mismatched;
    return *this;
  }
};

/// The device failed, or there is none: what() says why, and what to do. Its seeds are lost.
class DeviceError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The seeds of Algorithm 1, where a device has them, and steps 1 and 2, which run there. Seeds lie
/// in slots 0, 1, 2 ... in the order in which they were planted; which of them are a group, the
/// caller knows. Threads are those of the caller's oneTBB arena. Not thread-safe.
class Backend {
 public:
  virtual ~Backend() = default;

  /// For people: "CPU, AVX2".
  virtual std::string name() const = 0;

  /// Slots in all: Options::max_seeds.
  virtual std::size_t capacity() const = 0;

  // All functions throw DeviceError where the device fails.

  /// The current frame, halved from level to level, which Update() and Plant() look at: it must be
  /// there as long as they do.
  virtual void SetFrame(std::span<const ImageView<std::uint8_t>> pyramid) = 0;

  /// Step 2: meets all seeds of the groups with the current frame: project, match, fuse, judge.
  /// Writes their posterior, counts and fate; seeds of no group, of which there may be many, stay
  /// as they are. All groups' cameras have the model `model`.
  virtual UpdateStatistics Update(std::span<const SeedGroup> groups, CameraModel model) = 0;

  /// Gives the seeds whose fate was decided and was not given before, in the order of their slots,
  /// and counts them as removed. Valid until the next call of any function.
  virtual std::span<const EndedSeed> TakeEnded() = 0;

  /// Closes the gaps that removed seeds left; the order is kept.
  virtual void Compact() = 0;

  /// Step 1: plants new seeds in the current frame where a point is still missing, behind those
  /// that are there, one level after the other from the coarsest on. Returns how many on each
  /// level.
  ///
  /// A pixel gets a seed if its patch has texture, its ray crosses the scene's range, and neither a
  /// live seed of the groups nor a point that was seen from a similar direction projects near it.
  /// Where there are more such pixels than free slots, they are thinned evenly over the picture.
  virtual std::vector<std::size_t> Plant(const Planting& planting) = 0;

  /// The points of the next planting are others than those before.
  virtual void ForgetPoints() = 0;

  /// The seeds in the slots begin, begin + step ... below end: for looking at them.
  virtual std::vector<SeedState> Read(std::size_t begin, std::size_t end, std::size_t step) = 0;

  /// The patches of slots [begin, end), kPatchPixels each, row-major: for looking at them.
  virtual std::vector<std::uint8_t> ReadPatches(std::size_t begin, std::size_t end) = 0;
};

/// An environment variable with the name of the instruction set to use, for tests and comparisons:
/// "AVX-512 VNNI gathers", "AVX-512 VNNI", "AVX-512", "AVX2" or "portable". Results are the same
/// with all.
inline constexpr const char* kInstructionsVariable = "LIVEMVS_INSTRUCTIONS";

/// The CPU backend, for the fastest instructions that the processor has. Options are copied.
/// @throws std::invalid_argument where the environment asks for instructions that it has not.
std::unique_ptr<Backend> MakeCpuBackend(const Options& options);

/// The backend that Options::backend asks for; with kAuto the CPU where the GPU cannot be used.
/// @throws DeviceError where it asks for a GPU that cannot be used.
std::unique_ptr<Backend> MakeBackend(const Options& options);

}  // namespace livemvs
