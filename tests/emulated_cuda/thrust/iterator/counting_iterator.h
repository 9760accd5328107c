#pragma once

#include <cstddef>

namespace thrust {

template <typename T>
struct counting_iterator {
  explicit counting_iterator(T from) : first(from) {}
  T operator[](std::size_t i) const { return static_cast<T>(first + i); }
  T first;
};

}  // namespace thrust
