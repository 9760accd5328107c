#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "livemvs/core/frame.h"

namespace livemvs::viewer {

/// Makes small JPEGs of pictures, keeping the encoder between them. Not thread-safe.
class PreviewEncoder {
 public:
  /// @param most_width  Wider pictures are shrunk to it [px].
  explicit PreviewEncoder(int most_width);
  ~PreviewEncoder();

  /// A JPEG, or nothing where the encoder fails.
  std::vector<std::uint8_t> Encode(const Picture& picture);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// The mean squared step between pixels that are neighbours in a row: what blur
/// takes away. [grey levels²]
double Sharpness(const ImageView<std::uint8_t>& grey);

}  // namespace livemvs::viewer
