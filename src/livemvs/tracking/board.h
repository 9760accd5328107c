#pragma once

#include <Eigen/Core>
#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "livemvs/core/point.h"

namespace livemvs {

/// A rectangle of squares that is left white, for the object to stand on.
struct PlainArea {
  int column = 0, row = 0;    ///< Of its upper left square.
  int columns = 0, rows = 0;  ///< [squares]
};

/// A printed sheet of chessboard squares with a marker in each white one (ChArUco). Columns count
/// from the left, rows from the top of the sheet as it is read.
///
/// The world: origin at the middle of the squares, x to the right and y up on the sheet, z = 0 on
/// the paper and positive towards the objects; metres.
struct Board {
  int columns = 12;                         ///< [squares]
  int rows = 8;                             ///< [squares]
  double square = 0.035;                    ///< Side of a square [m].
  double marker = 0.026;                    ///< Side of a marker with its black border [m].
  std::string dictionary = "DICT_4X4_250";  ///< OpenCV's name.
  int first_id = 0;                         ///< Of the marker in the first white square.
  /// Whether the upper left square is black, as OpenCV up to 4.6 draws it for any number of rows.
  bool top_left_black = true;
  std::optional<PlainArea> plain;

  /// @throws std::invalid_argument naming the field, its value and the remedy.
  void Check() const;

  double width() const { return columns * square; }  ///< [m]
  double height() const { return rows * square; }    ///< [m]

  bool IsBlack(int column, int row) const { return ((column + row) % 2 == 0) == top_left_black; }
  bool IsPlain(int column, int row) const;

  /// The point of the sheet at a number of squares from its upper left corner. [m]
  Eigen::Vector3d PointAt(double columns_from_left, double rows_from_top) const;
};

/// A place where four printed squares meet.
struct BoardCorner {
  int id = 0;                   ///< Column + row * (columns - 1), both from 0 (OpenCV's number).
  Eigen::Vector3d point;        ///< In the world [m].
  bool black_up_right = false;  ///< Whether the square towards (+x, +y) is black.
};

/// A marker as it is printed.
struct BoardMarker {
  int id = 0;
  int column = 0, row = 0;  ///< Its square.
  /// Corners in the world [m], from the upper left one clockwise as the sheet is read.
  std::array<Eigen::Vector3d, 4> corners;
};

/// The corners that are printed, by ascending number.
std::vector<BoardCorner> CornersOf(const Board& board);

/// The markers that are printed, by ascending number. White squares are numbered row by row from
/// the upper left one; those of the plain area keep their numbers and are left out.
std::vector<BoardMarker> MarkersOf(const Board& board);

/// The room above the sheet that is reconstructed: as wide as the squares, from just below the
/// paper to `height` above it [m]; half of the sheet's longer side where that is not given.
Box BoxAbove(const Board& board, double height = 0);

/// Reads a sheet's description as WriteBoard writes it. The lists of corners and markers are for
/// other programs; where the file has them they must agree with the layout.
/// @throws Error (kBadInput) naming file, field, value and remedy.
Board ReadBoard(const std::filesystem::path& file);

/// Writes the description: kind, dictionary, squares, sizes, layout, and where corners and markers
/// are. The file appears whole or not at all.
/// @throws Error (kOutOfResource) where it cannot be written.
void WriteBoard(const std::filesystem::path& file, const Board& board);

}  // namespace livemvs
