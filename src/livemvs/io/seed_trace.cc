#include "livemvs/io/seed_trace.h"

#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <fstream>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>

#include "livemvs/core/error.h"

namespace livemvs {
namespace {

static_assert(std::endian::native == std::endian::little, "seed traces are little-endian");

constexpr std::uint32_t kVersion = 2;
constexpr int kMostLevels = 6;  // more than Options::levels allows is damage
constexpr std::size_t kMagicSize = sizeof(kSeedTraceMagic) - 1;

struct Header {
  char magic[kMagicSize];
  std::uint32_t version;
  std::uint32_t record_size;
  std::uint64_t count;
};
static_assert(sizeof(Header) == 24);

struct FileRecord {
  std::uint32_t birth_frame, end_frame;
  float x, y, depth, sigma;
  std::uint16_t views;
  std::uint8_t fate;
  std::uint8_t level;
};
static_assert(sizeof(FileRecord) == 28);

Header MakeHeader(std::uint64_t count) {
  Header header{{}, kVersion, sizeof(FileRecord), count};
  std::memcpy(header.magic, kSeedTraceMagic, kMagicSize);
  return header;
}

// What is wrong with a record, if anything.
std::optional<std::string> FaultOf(const FileRecord& r) {
  if (r.level >= kMostLevels) return "the level is unknown";
  if (!std::isfinite(r.x) || !std::isfinite(r.y)) return "the pixel is not finite";
  if (!std::isfinite(r.depth) || r.depth < 0) return "the depth is not a positive number";
  if (!std::isfinite(r.sigma) || r.sigma < 0) return "sigma is not a positive number";
  if (r.fate >= static_cast<std::uint8_t>(Fate::kRemoved)) return "the fate is unknown";
  const auto fate = static_cast<Fate>(r.fate);
  if ((fate == Fate::kConverged || fate == Fate::kTakenOut) && r.depth == 0) {
    return "a converged seed has no depth";
  }
  if (r.end_frame < r.birth_frame) return "the seed ends before its birth";
  return {};
}

}  // namespace

SeedTraceWriter::SeedTraceWriter(const std::filesystem::path& path) : file_(path) {
  const Header header = MakeHeader(0);
  file_.Write(&header, sizeof(header));
}

void SeedTraceWriter::Write(const SeedRecord& record) {
  constexpr std::int64_t kMost = std::numeric_limits<std::uint32_t>::max();
  if (record.birth_frame < 0 || record.birth_frame > kMost || record.end_frame < 0 ||
      record.end_frame > kMost) {
    throw std::invalid_argument("seed record: frame indices must be 0 to 2^32 - 1");
  }
  const FileRecord r{static_cast<std::uint32_t>(record.birth_frame),
                     static_cast<std::uint32_t>(record.end_frame),
                     record.x,
                     record.y,
                     record.depth,
                     record.sigma,
                     record.views,
                     static_cast<std::uint8_t>(record.fate),
                     record.level};
  if (const auto fault = FaultOf(r)) throw std::invalid_argument("seed record: " + *fault);
  file_.Write(&r, sizeof(r));
  ++count_;
}

void SeedTraceWriter::SetFate(std::uint64_t index, Fate fate) {
  if (index >= count_) throw std::invalid_argument("seed trace: there is no such seed");
  const auto number = static_cast<std::uint8_t>(fate);
  file_.Seek(static_cast<std::int64_t>(sizeof(Header) + index * sizeof(FileRecord) +
                                       offsetof(FileRecord, fate)));
  file_.Write(&number, sizeof(number));
  file_.Seek(file_.size());
}

void SeedTraceWriter::Finish() {
  const Header header = MakeHeader(count_);
  file_.Seek(0);
  file_.Write(&header, sizeof(header));
  file_.Commit();
}

std::vector<SeedRecord> ReadSeedTrace(const std::filesystem::path& path) {
  std::error_code error;
  const std::uint64_t size = std::filesystem::file_size(path, error);
  std::ifstream stream(path, std::ios::binary);
  if (error || !stream) throw BadInput(path.string() + ": cannot be read");
  Header header{};
  if (!stream.read(reinterpret_cast<char*>(&header), sizeof(header)) ||
      std::memcmp(header.magic, kSeedTraceMagic, kMagicSize) != 0) {
    throw BadInput(path.string() + ": is not a seed trace; 'livemvs run --trace' writes them");
  }
  if (header.version != kVersion || header.record_size != sizeof(FileRecord)) {
    throw BadInput(path.string() + ": is a seed trace of version " +
                   std::to_string(header.version) + ", not " + std::to_string(kVersion) +
                   "; write it again with this program");
  }
  const std::uint64_t bytes = size - sizeof(header);
  if (header.count != bytes / sizeof(FileRecord) || bytes % sizeof(FileRecord) != 0) {
    throw BadInput(path.string() + ": states " + std::to_string(header.count) +
                   " seeds, but its size is that of " + std::to_string(bytes / sizeof(FileRecord)) +
                   "; the file is damaged or cut");
  }
  std::vector<SeedRecord> records;
  records.reserve(header.count);
  for (std::uint64_t i = 0; i < header.count; ++i) {
    FileRecord r;
    if (!stream.read(reinterpret_cast<char*>(&r), sizeof(r))) {
      throw BadInput(path.string() + ": seed " + std::to_string(i) + ": cannot be read");
    }
    if (const auto fault = FaultOf(r)) {
      throw BadInput(path.string() + ": seed " + std::to_string(i) + ": " + *fault);
    }
    records.push_back({r.birth_frame,
                       r.x,
                       r.y,
                       r.end_frame,
                       static_cast<Fate>(r.fate),
                       r.views,
                       r.depth,
                       r.sigma,
                       r.level});
  }
  return records;
}

}  // namespace livemvs
