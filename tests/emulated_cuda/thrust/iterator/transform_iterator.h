#pragma once

#include <cstddef>

namespace thrust {

template <typename Function, typename Iterator>
struct transform_iterator {
  auto operator[](std::size_t i) const { return function(from[i]); }
  Iterator from;
  Function function;
};

template <typename Iterator, typename Function>
transform_iterator<Function, Iterator> make_transform_iterator(Iterator from, Function function) {
  return {from, function};
}

}  // namespace thrust
