#pragma once

#include <cassert>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <new>
#include <utility>

#include "livemvs/core/platform.h"

namespace livemvs {

/// A read-only view of a row-major image, (height, width), rows `stride` elements apart.
/// Pixel centres are at integer coordinates: (0, 0) is the centre of the top-left pixel.
template <typename T>
struct ImageView {
  const T* data = nullptr;
  int width = 0;
  int height = 0;
  std::ptrdiff_t stride = 0;

  LIVEMVS_HD const T* Row(int y) const { return data + y * stride; }
  LIVEMVS_HD const T& operator()(int x, int y) const { return data[y * stride + x]; }
};

/// An owned, move-only image. Rows start on 64-byte boundaries, and at least 64 bytes may be read
/// past the end of every row (the last included), so that kernels can load whole vectors.
template <typename T>
class Image {
 public:
  Image() = default;

  /// Allocates (height, width) elements, zeroed.
  Image(int width, int height) : width_(width), height_(height) {
    assert(width >= 0 && height >= 0);
    constexpr std::size_t kPerLine = kAlignment / sizeof(T);
    stride_ = static_cast<std::ptrdiff_t>((width + kPerLine - 1) / kPerLine * kPerLine);
    const std::size_t count = static_cast<std::size_t>(stride_) * height + kPerLine;
    data_.reset(static_cast<T*>(::operator new (count * sizeof(T), std::align_val_t{kAlignment})));
    std::memset(static_cast<void*>(data_.get()), 0, count * sizeof(T));
  }

  Image(Image&& other) noexcept { *this = std::move(other); }
  Image& operator=(Image&& other) noexcept {
    width_ = std::exchange(other.width_, 0);
    height_ = std::exchange(other.height_, 0);
    stride_ = std::exchange(other.stride_, 0);
    data_ = std::move(other.data_);
    return *this;
  }

  int width() const { return width_; }
  int height() const { return height_; }
  std::ptrdiff_t stride() const { return stride_; }
  bool empty() const { return width_ == 0 || height_ == 0; }

  T* Row(int y) { return data_.get() + y * stride_; }
  const T* Row(int y) const { return data_.get() + y * stride_; }
  T& operator()(int x, int y) { return Row(y)[x]; }
  const T& operator()(int x, int y) const { return Row(y)[x]; }

  ImageView<T> view() const { return {data_.get(), width_, height_, stride_}; }

 private:
  static constexpr std::size_t kAlignment = 64;
  struct Free {
    void operator()(T* p) const { ::operator delete (p, std::align_val_t{kAlignment}); }
  };
  static_assert(std::is_trivially_copyable_v<T>);

  int width_ = 0;
  int height_ = 0;
  std::ptrdiff_t stride_ = 0;
  std::unique_ptr<T[], Free> data_;
};

}  // namespace livemvs
