#pragma once

#include <stdexcept>
#include <string>

namespace livemvs {

/// What Board::Check() throws: the field by its name in Board, for who calls it by another.
struct BoardFlaw : std::invalid_argument {
  BoardFlaw(const std::string& wrong_field, const std::string& what_is_wrong_with_it)
      : std::invalid_argument("board: " + wrong_field + " " + what_is_wrong_with_it),
        field(wrong_field),
        what_is_wrong(what_is_wrong_with_it) {}

  std::string field;
  std::string what_is_wrong;  ///< Its value, and what it must be.
};

}  // namespace livemvs
