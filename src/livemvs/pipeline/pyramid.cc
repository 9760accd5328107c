#include "livemvs/pipeline/pyramid.h"

#include "livemvs/parallel/parallel_for.h"

namespace livemvs {
namespace {

constexpr int kSmallestSide = 16;  // [px]
constexpr std::size_t kRowsPerTask = 64;

void Halve(const ImageView<std::uint8_t>& from, Image<std::uint8_t>* to) {
  ParallelForRange(0, to->height(), kRowsPerTask, [&](std::size_t first, std::size_t last) {
    for (int y = static_cast<int>(first); y < static_cast<int>(last); ++y) {
      const std::uint8_t* a = from.Row(2 * y);
      const std::uint8_t* b = from.Row(2 * y + 1);
      std::uint8_t* out = to->Row(y);
      for (int x = 0; x < to->width(); ++x) {
        out[x] =
            static_cast<std::uint8_t>((a[2 * x] + a[2 * x + 1] + b[2 * x] + b[2 * x + 1] + 2) / 4);
      }
    }
  });
}

}  // namespace

void Pyramid::Build(const Image<std::uint8_t>& grey, int levels) {
  views_.assign(1, grey.view());
  halves_.resize(static_cast<std::size_t>(levels - 1));
  for (Image<std::uint8_t>& half : halves_) {
    const ImageView<std::uint8_t> from = views_.back();
    const int width = from.width / 2, height = from.height / 2;
    if (width < kSmallestSide || height < kSmallestSide) break;
    if (half.width() != width || half.height() != height) half = Image<std::uint8_t>(width, height);
    Halve(from, &half);
    views_.push_back(half.view());
  }
}

}  // namespace livemvs
