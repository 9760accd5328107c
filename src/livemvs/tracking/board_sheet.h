#pragma once

#include <filesystem>
#include <string>

#include "livemvs/core/image.h"
#include "livemvs/tracking/board.h"

namespace livemvs {

/// The paper that a board is printed on.
struct Page {
  std::string name;   ///< "A4", "A3", "Letter", or "fit": as large as board and margins need.
  double width = 0;   ///< [m], landscape
  double height = 0;  ///< [m]
};

/// @throws std::invalid_argument for an unknown name. "fit" needs the board.
Page PageByName(const std::string& name, const Board& board);

/// A board of 12 x 8 squares that fills a page: A4 22 mm, A3 32 mm, Letter 21 mm a square.
Board BoardForPage(const std::string& page);

/// Writes the sheet as PDF of exactly the page's size: the board in the middle, and below it a
/// ruler of 100 mm (50 mm on small pages) to check the scale of the print.
/// @throws std::invalid_argument where the board does not fit the page with 5 mm to spare;
/// Error (kOutOfResource) where the file cannot be written.
void WriteSheetPdf(const std::filesystem::path& path, const Board& board, const Page& page);

/// The sheet as a picture, edges between pixels by coverage; without words.
/// @param dots_per_inch  36 to 2400.
Image<std::uint8_t> DrawSheet(const Board& board, const Page& page, double dots_per_inch);

/// The board alone, without any margin: (rows, columns) * pixels_per_square pixels, the corner of
/// the first square at the corner of the first pixel.
Image<std::uint8_t> DrawBoard(const Board& board, int pixels_per_square);

}  // namespace livemvs
