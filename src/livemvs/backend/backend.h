#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "livemvs/backend/seed_columns.h"
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

/// Runs step 2 of Algorithm 1 on a device. Threads are those of the caller's oneTBB arena.
class Backend {
 public:
  virtual ~Backend() = default;

  /// For people: "CPU, AVX2".
  virtual std::string name() const = 0;

  /// Meets all seeds of the groups with the current frame: project, match, fuse, judge. Writes
  /// their posterior, counts and fate. All groups' cameras have the model `model`.
  /// @param pyramid  The current frame, halved from level to level.
  virtual UpdateStatistics Update(const SeedColumns& seeds,
                                  const std::vector<SeedGroup>& groups,
                                  CameraModel model,
                                  std::span<const ImageView<std::uint8_t>> pyramid) = 0;

  /// Sets the pixels to 1 that the living seeds of the groups project to, in the picture of their
  /// level.
  virtual void MarkPlaces(const SeedColumns& seeds,
                          const std::vector<SeedGroup>& groups,
                          CameraModel model,
                          std::span<Image<std::uint8_t>> marks) = 0;
};

/// An environment variable with the name of the instruction set to use, for tests and comparisons:
/// "AVX-512 VNNI", "AVX-512", "AVX2" or "portable". Results are the same with all.
inline constexpr const char* kInstructionsVariable = "LIVEMVS_INSTRUCTIONS";

/// The CPU backend, for the fastest instructions that the processor has. Options are copied.
/// @throws std::invalid_argument where the environment asks for instructions that it has not.
std::unique_ptr<Backend> MakeCpuBackend(const Options& options);

}  // namespace livemvs
