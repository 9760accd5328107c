#include "livemvs/backend/cpu/row_pairs.h"

#include <algorithm>

#include "livemvs/parallel/parallel_for.h"

namespace livemvs {

void RowPairs::Build(const ImageView<std::uint8_t>& image) {
  if (pairs_.width() != image.width || pairs_.height() != image.height) {
    pairs_ = Image<std::uint16_t>(image.width, image.height);
  }
  constexpr std::size_t kRows = 32;
  const auto build_rows = [&](std::size_t first, std::size_t last) {
    for (int y = static_cast<int>(first); y < static_cast<int>(last); ++y) {
      const std::uint8_t* upper = image.Row(y);
      const std::uint8_t* lower = image.Row(std::min(y + 1, image.height - 1));
      std::uint16_t* row = pairs_.Row(y);
      for (int x = 0; x < image.width; ++x) {
        row[x] = static_cast<std::uint16_t>((upper[x] | lower[x] << 8) ^ 0x8080);
      }
    }
  };
  ParallelForRange(0, static_cast<std::size_t>(image.height), kRows, build_rows);
}

}  // namespace livemvs
