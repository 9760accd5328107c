#include "livemvs/tracking/downsample.h"

#include <algorithm>
#include <cassert>
#include <vector>

namespace livemvs {

Image<std::uint8_t> Downsample(ImageView<std::uint8_t> image, int factor) {
  assert(factor >= 1 && factor <= 16);  // so that sums fit 16 bits
  Image<std::uint8_t> small(image.width / factor, image.height / factor);
  const int used = small.width() * factor;
  std::vector<std::uint16_t> sums(static_cast<std::size_t>(used));
  std::uint16_t* const sum = sums.data();
  const int count = factor * factor;
  for (int y = 0; y < small.height(); ++y) {
    std::fill(sums.begin(), sums.end(), std::uint16_t{0});
    for (int i = 0; i < factor; ++i) {
      const std::uint8_t* const row = image.Row(y * factor + i);
      for (int x = 0; x < used; ++x) sum[x] = static_cast<std::uint16_t>(sum[x] + row[x]);
    }
    std::uint8_t* const out = small.Row(y);
    for (int x = 0; x < small.width(); ++x) {
      int total = count / 2;
      for (int i = 0; i < factor; ++i) total += sum[x * factor + i];
      out[x] = static_cast<std::uint8_t>(total / count);
    }
  }
  return small;
}

}  // namespace livemvs
