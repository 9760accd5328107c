#include "livemvs/tracking/board.h"

#include <algorithm>
#include <cstdio>
#include <stdexcept>

#include "livemvs/io/dataset_text.h"
#include "livemvs/tracking/board_flaw.h"
#include "livemvs/tracking/dictionary.h"

namespace livemvs {
namespace {

constexpr int kMaxSquares = 200;     // along a side
constexpr double kMaxSquare = 10;    // [m]
constexpr double kMinSquare = 1e-4;  // [m]
// Below the paper: it is not quite flat, and its surface is to be part of the model. [m]
constexpr double kBelowPaper = 0.005;

void Require(bool good, const std::string& field, const std::string& value, const char* must) {
  if (!good) throw BoardFlaw(field, value + ": " + must);
}

std::string Number(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

void CheckPlain(const Board& board) {
  const PlainArea& p = *board.plain;
  const std::string value = std::to_string(p.column) + "," + std::to_string(p.row) + "," +
                            std::to_string(p.columns) + "," + std::to_string(p.rows);
  // Compared without sums, which could overflow.
  Require(p.column >= 0 && p.row >= 0 && p.columns >= 1 && p.rows >= 1 &&
              p.columns <= board.columns - p.column && p.rows <= board.rows - p.row,
          "plain",
          value,
          "must be column,row,columns,rows of squares on the sheet");
}

int WhiteSquares(const Board& board) {
  const int all = board.columns * board.rows;
  return board.top_left_black ? all / 2 : all - all / 2;
}

}  // namespace

void Board::Check() const {
  Require(columns >= 3 && columns <= kMaxSquares,
          "columns",
          std::to_string(columns),
          "must be 3 to 200");
  Require(rows >= 3 && rows <= kMaxSquares, "rows", std::to_string(rows), "must be 3 to 200");
  Require(square >= kMinSquare && square <= kMaxSquare,
          "square",
          Number(square),
          "must be a length in metres, 0.0001 to 10");
  Require(marker >= 0.3 * square && marker <= 0.95 * square,
          "marker",
          Number(marker),
          "must be 0.3 to 0.95 of the square's side");
  const int codes = DictionarySize(dictionary);
  Require(codes > 0, "dictionary", "'" + Shortened(dictionary) + "'", KnownDictionaries());
  Require(first_id >= 0, "first_id", std::to_string(first_id), "must not be negative");
  Require(first_id <= codes - WhiteSquares(*this),
          "dictionary",
          dictionary,
          "has fewer codes than the sheet has white squares (after first_id); take a larger one");
  if (plain) CheckPlain(*this);
  Require(CornersOf(*this).size() >= 8,
          "plain",
          "area",
          "leaves fewer than 8 corners of squares; take more squares or a smaller plain area");
}

bool Board::IsPlain(int column, int row) const {
  return plain && column >= plain->column && column < plain->column + plain->columns &&
         row >= plain->row && row < plain->row + plain->rows;
}

Eigen::Vector3d Board::PointAt(double columns_from_left, double rows_from_top) const {
  return {(columns_from_left - 0.5 * columns) * square, (0.5 * rows - rows_from_top) * square, 0};
}

std::vector<BoardCorner> CornersOf(const Board& board) {
  std::vector<BoardCorner> corners;
  for (int row = 1; row < board.rows; ++row) {
    for (int column = 1; column < board.columns; ++column) {
      if (board.IsPlain(column, row) || board.IsPlain(column - 1, row) ||
          board.IsPlain(column, row - 1) || board.IsPlain(column - 1, row - 1)) {
        continue;
      }
      BoardCorner corner;
      corner.id = column - 1 + (row - 1) * (board.columns - 1);
      corner.point = board.PointAt(column, row);
      corner.black_up_right = board.IsBlack(column, row - 1);
      corners.push_back(corner);
    }
  }
  return corners;
}

std::vector<BoardMarker> MarkersOf(const Board& board) {
  std::vector<BoardMarker> markers;
  const double low = 0.5 - 0.5 * board.marker / board.square, high = 1 - low;  // [squares]
  int id = board.first_id;
  for (int row = 0; row < board.rows; ++row) {
    for (int column = 0; column < board.columns; ++column) {
      if (board.IsBlack(column, row)) continue;
      const int own = id++;
      if (board.IsPlain(column, row)) continue;
      markers.push_back({own,
                         column,
                         row,
                         {board.PointAt(column + low, row + low),
                          board.PointAt(column + high, row + low),
                          board.PointAt(column + high, row + high),
                          board.PointAt(column + low, row + high)}});
    }
  }
  return markers;
}

Box BoxAbove(const Board& board, double height) {
  if (!(height >= 0)) throw std::invalid_argument("height above the board must not be negative");
  const double x = 0.5 * board.width(), y = 0.5 * board.height();
  const double z = height > 0 ? height : std::max(x, y);
  return {{-x, -y, -kBelowPaper}, {x, y, z}};
}

}  // namespace livemvs
