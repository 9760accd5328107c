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

/// What one update of all seeds did, by the status of the match and the fate that followed.
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

/// The seeds of Algorithm 1, where a device has them, and step 2, which runs there. Seeds lie in
/// slots 0, 1, 2 ... in the order in which they were appended; which of them are a group, the
/// caller knows. Threads are those of the caller's oneTBB arena. Not thread-safe.
class Backend {
 public:
  virtual ~Backend() = default;

  /// For people: "CPU, AVX2".
  virtual std::string name() const = 0;

  /// Slots in all: Options::max_seeds.
  virtual std::size_t capacity() const = 0;

  // All functions throw DeviceError where the device fails.

  /// Puts newborn seeds behind those that are there; all start with the same posterior.
  /// @throws std::length_error where there would be more than the capacity.
  virtual void Append(std::span<const NewSeed> seeds, const Posterior<float>& prior) = 0;

  /// Meets all seeds of the groups with the current frame: project, match, fuse, judge. Writes
  /// their posterior, counts and fate. All groups' cameras have the model `model`.
  /// @param pyramid  The current frame, halved from level to level.
  virtual UpdateStatistics Update(const std::vector<SeedGroup>& groups,
                                  CameraModel model,
                                  std::span<const ImageView<std::uint8_t>> pyramid) = 0;

  /// Gives the seeds whose fate was decided and was not given before, in the order of their slots,
  /// and counts them as removed. Valid until the next call of any function.
  virtual std::span<const EndedSeed> TakeEnded() = 0;

  /// Closes the gaps that removed seeds left; the order is kept.
  virtual void Compact() = 0;

  /// Sets the pixels to 1 that the living seeds of the groups project to, in the picture of their
  /// level. The pictures are all 0 before.
  virtual void MarkPlaces(const std::vector<SeedGroup>& groups,
                          CameraModel model,
                          std::span<Image<std::uint8_t>> marks) = 0;

  /// The seeds in the slots begin, begin + step ... below end: for looking at them.
  virtual std::vector<SeedState> Read(std::size_t begin, std::size_t end, std::size_t step) = 0;

  /// The patches of slots [begin, end), kPatchPixels each, row-major: for looking at them.
  virtual std::vector<std::uint8_t> ReadPatches(std::size_t begin, std::size_t end) = 0;
};

/// An environment variable with the name of the instruction set to use, for tests and comparisons:
/// "AVX-512 VNNI", "AVX-512", "AVX2" or "portable". Results are the same with all.
inline constexpr const char* kInstructionsVariable = "LIVEMVS_INSTRUCTIONS";

/// The CPU backend, for the fastest instructions that the processor has. Options are copied.
/// @throws std::invalid_argument where the environment asks for instructions that it has not.
std::unique_ptr<Backend> MakeCpuBackend(const Options& options);

/// The backend that Options::backend asks for; with kAuto the CPU where the GPU cannot be used.
/// @throws DeviceError where it asks for a GPU that cannot be used.
std::unique_ptr<Backend> MakeBackend(const Options& options);

}  // namespace livemvs
