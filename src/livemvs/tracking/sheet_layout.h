#pragma once

#include <string>
#include <vector>

#include "livemvs/tracking/board.h"
#include "livemvs/tracking/board_sheet.h"

namespace livemvs {

/// What is printed where, in metres from the page's upper left corner, y down.
struct SheetLayout {
  struct Rect {
    double x, y, width, height;
  };
  struct Text {
    double x, y;  ///< Of the start of the base line.
    double size;  ///< Of the letters.
    std::string words;
  };
  /// Rectangles of one colour that make one shape each; later layers lie on earlier ones.
  struct Layer {
    bool white;
    std::vector<Rect> rects;
  };
  std::vector<Layer> layers;
  std::vector<Text> texts;
};

/// The squares and markers, the board's upper left corner at (left, top).
void AddBoard(const Board& board, double left, double top, SheetLayout* layout);

/// The whole sheet.
/// @throws std::invalid_argument where the board does not fit.
SheetLayout LayOutSheet(const Board& board, const Page& page);

/// Paints a layout onto white, each pixel by its covered area.
Image<std::uint8_t> Paint(const SheetLayout& layout,
                          int width,
                          int height,
                          double pixels_per_metre);

}  // namespace livemvs
