#include "livemvs/tracking/board_sheet.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <opencv2/aruco/charuco.hpp>
#include <stdexcept>

#include "livemvs/tracking/marker_detector.h"
#include "livemvs/tracking/opencv_dictionary.h"

namespace livemvs {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

std::string PdfOf(const Board& board, const std::string& page) {
  const fs::path path = fs::path(testing::TempDir()) / "sheet.pdf";
  WriteSheetPdf(path, board, PageByName(page, board));
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

// OpenCV's drawing of the board as oracle, where all edges lie between pixels.
TEST(BoardSheetTest, DrawingIsOpenCvs) {
  const Board board;
  constexpr int kPixels = 210;  // a square; a marker has 156 of them, a bit 26, the margin 27
  const Image<std::uint8_t> ours = DrawBoard(board, kPixels);
  cv::Mat theirs;
  cv::aruco::CharucoBoard::create(
      board.columns, board.rows, 0.035F, 0.026F, OpenCvDictionary(board.dictionary))
      ->draw(cv::Size(board.columns * kPixels, board.rows * kPixels), theirs);
  ASSERT_EQ(ours.width(), theirs.cols);
  int different = 0;
  for (int y = 0; y < theirs.rows; ++y) {
    for (int x = 0; x < theirs.cols; ++x) {
      different += std::abs(ours(x, y) - theirs.at<std::uint8_t>(y, x)) > 127 ? 1 : 0;
    }
  }
  // OpenCV puts the edges of some bits a pixel further.
  EXPECT_LT(different, theirs.rows * theirs.cols / 100);
}

TEST(BoardSheetTest, MarkersOnTheDrawnPageAreWhereTheyShouldBe) {
  Board board = BoardForPage("A4");
  board.plain = PlainArea{4, 3, 4, 2};
  const Page page = PageByName("A4", board);
  const double per_metre = 150 / 0.0254;
  const Image<std::uint8_t> sheet = DrawSheet(board, page, 150);
  EXPECT_EQ(sheet.width(), static_cast<int>(std::ceil(0.297 * per_metre)));
  MarkerDetector detector(board, 100000);
  const std::vector<DetectedMarker> found = detector.Detect(sheet.view());
  ASSERT_EQ(found.size(), MarkersOf(board).size());
  const std::vector<BoardMarker> markers = MarkersOf(board);
  // The board is centred above the ruler: from any two markers follows the scale of the print.
  const auto& a = found.front();
  const auto& b = found.back();
  const double pixels = (a.corners[0] - b.corners[0]).norm();
  const double metres = (markers[a.index].corners[0] - markers[b.index].corners[0]).norm();
  EXPECT_NEAR(pixels / metres, per_metre, 0.005 * per_metre);
}

TEST(BoardSheetTest, PdfHasThePagesSizeAndAWorkingTable) {
  const std::string pdf = PdfOf(BoardForPage("A4"), "A4");
  EXPECT_EQ(pdf.substr(0, 5), "%PDF-");
  EXPECT_THAT(pdf, HasSubstr("/MediaBox [0 0 841.8898 595.2756]"));
  const std::size_t start = std::stoul(pdf.substr(pdf.rfind("startxref") + 10));
  ASSERT_EQ(pdf.substr(start, 4), "xref");
  for (int i = 1; i <= 5; ++i) {
    const std::size_t row = start + std::string("xref\n0 6\n").size() + 20 * i;
    const std::size_t offset = std::stoul(pdf.substr(row, 10));
    const std::string object = std::to_string(i) + " 0 obj";
    EXPECT_EQ(pdf.substr(offset, object.size()), object);
  }
}

TEST(BoardSheetTest, SquareHasItsSizeInThePdf) {
  const std::string pdf = PdfOf(BoardForPage("A3"), "A3");
  // 32 mm are 90.70866 points.
  EXPECT_THAT(pdf, HasSubstr(" 90.70866 90.70866 re"));
}

TEST(BoardSheetTest, ABoardThatDoesNotFitIsRefused) {
  const Board board;
  try {
    PdfOf(board, "A4");
    FAIL() << "no error";
  } catch (const std::invalid_argument& e) {
    EXPECT_THAT(e.what(), HasSubstr("does not fit the page A4"));
  }
  EXPECT_THROW(PageByName("A5", board), std::invalid_argument);
  EXPECT_THROW(DrawSheet(board, PageByName("fit", board), 1e9), std::invalid_argument);
  EXPECT_THROW(DrawBoard(board, 0), std::invalid_argument);
}

TEST(BoardSheetTest, StandardPagesHoldTheirBoards) {
  for (const char* page : {"A4", "A3", "Letter", "fit"}) {
    const Board board = BoardForPage(page);
    EXPECT_NO_THROW(PdfOf(board, page)) << page;
  }
}

}  // namespace
}  // namespace livemvs
