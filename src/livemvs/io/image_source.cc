#include "livemvs/io/image_source.h"

#include <algorithm>
#include <cctype>
#include <optional>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "livemvs/core/error.h"
#include "livemvs/core/log.h"
#include "livemvs/io/lower_case.h"
#include "livemvs/io/picture_codec.h"

namespace livemvs {
namespace {

namespace fs = std::filesystem;

bool IsDigit(char c) { return c >= '0' && c <= '9'; }

/// The run of digits at `i`, without leading zeros; moves `i` past it.
std::string_view TakeDigits(std::string_view text, std::size_t* i) {
  while (*i < text.size() && text[*i] == '0') ++*i;
  const std::size_t start = *i;
  while (*i < text.size() && IsDigit(text[*i])) ++*i;
  return text.substr(start, *i - start);
}

class ImageSource final : public FrameSource {
 public:
  ImageSource(std::vector<fs::path> files, double frames_per_second)
      : files_(std::move(files)), frames_per_second_(frames_per_second) {
    if (!(frames_per_second > 0)) {
      throw std::invalid_argument("OpenImages: frames_per_second must be positive");
    }
    if (files_.empty()) throw BadInput("there are no images to read");
    first_ = ReadNext();
    if (!first_) {
      throw BadInput(files_[0].parent_path().string() + ": not one of the " +
                     std::to_string(files_.size()) +
                     " images can be read; the first: " + first_problem_);
    }
    info_.width = first_->picture->width();
    info_.height = first_->picture->height();
    info_.frame_count = static_cast<std::int64_t>(files_.size());
    info_.description = std::to_string(files_.size()) + " images " + std::to_string(info_.width) +
                        " x " + std::to_string(info_.height);
  }

  Info info() const override { return info_; }
  Statistics statistics() const override { return statistics_; }

  std::optional<SourceFrame> Next() override {
    std::optional<SourceFrame> frame = first_ ? std::exchange(first_, std::nullopt) : ReadNext();
    if (frame) {
      ++statistics_.decoded;
    } else if (statistics_.skipped > 0 && !reported_) {
      reported_ = true;
      LogWarning(std::to_string(statistics_.skipped) + " of " + std::to_string(files_.size()) +
                 " images could not be read and were passed over; the first: " + first_problem_);
    }
    return frame;
  }

 private:
  std::optional<SourceFrame> ReadNext() {
    while (next_ < files_.size()) {
      const std::size_t index = next_++;
      try {
        SourceFrame frame;
        frame.picture = std::make_shared<const Picture>(ReadPicture(files_[index]));
        frame.index = static_cast<std::int64_t>(index);
        frame.timestamp = static_cast<double>(index) / frames_per_second_;
        frame.name = files_[index].filename().string();
        return frame;
      } catch (const Error& error) {
        if (error.kind() != ErrorKind::kBadInput) throw;
        if (statistics_.skipped++ == 0) first_problem_ = error.what();
      }
    }
    return std::nullopt;
  }

  std::vector<fs::path> files_;
  double frames_per_second_;
  std::size_t next_ = 0;
  std::optional<SourceFrame> first_;  ///< Read ahead, for the size.
  std::string first_problem_;
  bool reported_ = false;
  Info info_;
  Statistics statistics_;
};

}  // namespace

bool NaturalLess(const std::string& a, const std::string& b) {
  std::size_t i = 0, j = 0;
  while (i < a.size() && j < b.size()) {
    if (IsDigit(a[i]) && IsDigit(b[j])) {
      const std::string_view x = TakeDigits(a, &i), y = TakeDigits(b, &j);
      if (x.size() != y.size()) return x.size() < y.size();
      if (x != y) return x < y;
    } else if (a[i] != b[j]) {
      return static_cast<unsigned char>(a[i]) < static_cast<unsigned char>(b[j]);
    } else {
      ++i;
      ++j;
    }
  }
  if (i < a.size() || j < b.size()) return j < b.size();
  return a < b;  // Equal but for leading zeros.
}

bool HasImageExtension(const fs::path& path) {
  const std::string ending = LowerExtension(path);
  for (const char* known : {".png", ".jpg", ".jpeg", ".pgm", ".ppm", ".pnm"}) {
    if (ending == known) return true;
  }
  return false;
}

std::vector<fs::path> ListImages(const fs::path& folder) {
  std::error_code error;
  if (!fs::is_directory(folder, error)) {
    throw BadInput(folder.string() + ": is no folder of images; check the path");
  }
  std::vector<fs::path> files;
  fs::directory_iterator entry(folder, error);
  for (; !error && entry != fs::directory_iterator(); entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    std::error_code ignored;
    if (name[0] != '.' && HasImageExtension(name) && !entry->is_directory(ignored)) {
      files.push_back(entry->path());
    }
  }
  if (error) throw BadInput(folder.string() + ": cannot be listed: " + error.message());
  std::sort(files.begin(), files.end(), [](const fs::path& a, const fs::path& b) {
    return NaturalLess(a.filename().string(), b.filename().string());
  });
  return files;
}

std::unique_ptr<FrameSource> OpenImages(std::vector<fs::path> files, double frames_per_second) {
  return std::make_unique<ImageSource>(std::move(files), frames_per_second);
}

}  // namespace livemvs
