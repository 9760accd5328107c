#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "livemvs/core/seed_record.h"
#include "livemvs/io/atomic_file.h"

namespace livemvs {

/// The first bytes of a seed trace.
inline constexpr char kSeedTraceMagic[] = "LMVTRACE";

/// Writes what became of each seed of a run, record by record; docs/data-formats.md describes the
/// file. It appears whole with Finish(), or not at all. Not thread-safe.
class SeedTraceWriter {
 public:
  /// @throws Error (kOutOfResource) where the file cannot be made.
  explicit SeedTraceWriter(const std::filesystem::path& path);

  /// @throws std::invalid_argument for a record that ReadSeedTrace() would refuse; Error
  /// (kOutOfResource) where the disk is full.
  void Write(const SeedRecord& record);

  /// Changes what became of the index-th seed written.
  /// @throws std::invalid_argument where there is none.
  void SetFate(std::uint64_t index, Fate fate);

  /// Seeds written so far.
  std::uint64_t count() const { return count_; }

  void Finish();

 private:
  AtomicFile file_;
  std::uint64_t count_ = 0;
};

/// Reads a seed trace back, in the order in which it was written.
/// @throws Error (kBadInput) naming file and place where it is of another kind or version, cut
/// short, longer than it says, or holds a number that cannot be.
std::vector<SeedRecord> ReadSeedTrace(const std::filesystem::path& path);

}  // namespace livemvs
