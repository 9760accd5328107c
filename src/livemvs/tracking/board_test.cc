#include "livemvs/tracking/board.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <limits>
#include <opencv2/aruco/charuco.hpp>
#include <stdexcept>

#include "livemvs/core/error.h"
#include "livemvs/tracking/opencv_dictionary.h"
#include "temporary.h"

namespace livemvs {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using testing_support::Temporary;

constexpr double kRounding = 1e-6;  // OpenCV keeps coordinates in single precision [m]

fs::path File(const std::string& text) {
  const fs::path path = Temporary("board_hostile.json");
  std::ofstream(path, std::ios::binary) << text;
  return path;
}

std::string ReadError(const std::string& text) {
  try {
    ReadBoard(File(text));
  } catch (const Error& e) {
    EXPECT_EQ(e.kind(), ErrorKind::kBadInput);
    EXPECT_THAT(e.what(), HasSubstr("board_hostile.json"));
    return e.what();
  }
  return "";
}

std::string Written(const Board& board) {
  const fs::path path = Temporary("board_written.json");
  WriteBoard(path, board);
  std::ifstream in(path);
  return {std::istreambuf_iterator<char>(in), {}};
}

std::string Replaced(std::string text, const std::string& what, const std::string& by) {
  const std::size_t at = text.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return at == std::string::npos ? text : text.replace(at, what.size(), by);
}

std::string CheckError(const Board& board) {
  try {
    board.Check();
  } catch (const std::invalid_argument& e) {
    return e.what();
  }
  return "";
}

class BoardLayout : public testing::TestWithParam<std::pair<int, int>> {};

// OpenCV's own board as oracle: x to the right as ours, y from the sheet's top downwards.
TEST_P(BoardLayout, IsOpenCvs) {
  Board board;
  board.columns = GetParam().first;
  board.rows = GetParam().second;
  const auto theirs = cv::aruco::CharucoBoard::create(board.columns,
                                                      board.rows,
                                                      static_cast<float>(board.square),
                                                      static_cast<float>(board.marker),
                                                      OpenCvDictionary(board.dictionary));
  const auto ours_from_theirs = [&](const cv::Point3f& p) {
    return Eigen::Vector3d(p.x - 0.5 * board.width(), 0.5 * board.height() - p.y, 0);
  };
  const std::vector<BoardMarker> markers = MarkersOf(board);
  ASSERT_EQ(markers.size(), theirs->ids.size());
  for (std::size_t i = 0; i < markers.size(); ++i) {
    EXPECT_EQ(markers[i].id, theirs->ids[i]);
    for (int k = 0; k < 4; ++k) {
      EXPECT_LT((markers[i].corners[k] - ours_from_theirs(theirs->objPoints[i][k])).norm(),
                kRounding)
          << "marker " << i << " corner " << k;
    }
  }
  const std::vector<BoardCorner> corners = CornersOf(board);
  ASSERT_EQ(corners.size(), theirs->chessboardCorners.size());
  for (std::size_t i = 0; i < corners.size(); ++i) {
    EXPECT_EQ(corners[i].id, static_cast<int>(i));
    EXPECT_LT((corners[i].point - ours_from_theirs(theirs->chessboardCorners[i])).norm(),
              kRounding);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Sizes,
    BoardLayout,
    testing::Values(std::pair(12, 8), std::pair(5, 7), std::pair(7, 5), std::pair(6, 3)));

TEST(BoardTest, PlainAreaTakesItsMarkersAndTheCornersAroundIt) {
  Board board;
  board.plain = PlainArea{4, 3, 4, 2};
  board.Check();
  EXPECT_EQ(MarkersOf(board).size(), 44u);
  EXPECT_EQ(CornersOf(board).size(), 77u - 5 * 3);
  for (const BoardMarker& m : MarkersOf(board)) {
    EXPECT_FALSE(m.column >= 4 && m.column < 8 && m.row >= 3 && m.row < 5);
  }
  // The others keep their numbers.
  EXPECT_EQ(MarkersOf(board).back().id, 47);
}

TEST(BoardTest, BoxStandsOnTheSheet) {
  const Box box = BoxAbove(Board());
  EXPECT_DOUBLE_EQ(box.max.x(), 0.21);
  EXPECT_DOUBLE_EQ(box.min.y(), -0.14);
  EXPECT_DOUBLE_EQ(box.max.z(), 0.21);
  EXPECT_LT(box.min.z(), 0);
  EXPECT_DOUBLE_EQ(BoxAbove(Board(), 0.3).max.z(), 0.3);
  EXPECT_THROW(BoxAbove(Board(), -1), std::invalid_argument);
}

TEST(BoardTest, DescriptionComesBack) {
  Board board;
  board.columns = 9;
  board.rows = 7;
  board.square = 0.0213;
  board.marker = 0.0151;
  board.dictionary = "DICT_5X5_100";
  board.first_id = 3;
  board.top_left_black = false;
  board.plain = PlainArea{3, 2, 3, 2};
  WriteBoard(Temporary("board.json"), board);
  const Board read = ReadBoard(Temporary("board.json"));
  EXPECT_EQ(read.columns, 9);
  EXPECT_EQ(read.rows, 7);
  EXPECT_EQ(read.square, board.square);
  EXPECT_EQ(read.marker, board.marker);
  EXPECT_EQ(read.dictionary, board.dictionary);
  EXPECT_EQ(read.first_id, 3);
  EXPECT_FALSE(read.top_left_black);
  ASSERT_TRUE(read.plain.has_value());
  EXPECT_EQ(read.plain->columns, 3);
}

TEST(BoardTest, HostileFilesAreRefused) {
  EXPECT_THAT(ReadError(""), HasSubstr("the file is empty"));
  EXPECT_THAT(ReadError("[1, 2"), HasSubstr("not valid JSON"));
  EXPECT_THAT(ReadError("[1, 2]"), HasSubstr("no JSON object"));
  EXPECT_THAT(ReadError("{}"), HasSubstr("'format'"));
  EXPECT_THAT(ReadError(std::string(100000, '[')), HasSubstr("nested deeper than 16"));
  const std::string good = Written(Board());
  EXPECT_EQ(ReadError(good), "");
  EXPECT_THAT(ReadError(good.substr(0, good.size() / 2)), HasSubstr("not valid JSON"));
}

// What is wrong in a description that is right otherwise, and what must be said of it.
struct Fault {
  const char* what;
  const char* by;
  const char* key;
  const char* says = "";
};

TEST(BoardTest, EachFaultIsNamedByItsKey) {
  const std::string good = Written(Board());
  const Fault faults[] = {
      {"[12, 8]", "[1e9, 8]", "'squares'", "no whole number"},
      {"[12, 8]", "[99999999999999999999, 8]", "'squares'", "no whole number"},
      {"[12, 8]", "[1000000, 1000000]", "'squares'", "must be 3 to 200"},
      {"[12, 8]", "[-12, 8]", "'squares'", "must be 3 to 200"},
      {"[12, 8]", "[12, 8, 1]", "'squares'", "a list of 2"},
      {"[12, 8]", "12", "'squares'", "a list of 2"},
      {"0.035,", "1e400,", "'square_m'", "not valid JSON"},
      {"0.035,", "NaN,", "'square_m'", "not valid JSON"},
      {"0.035,", "-Infinity,", "'square_m'", "not valid JSON"},
      {"0.035,", "-0.035,", "'square_m'", "-0.035: must be a length"},
      {"0.035,", "1e300,", "'square_m'", "1e+300: must be a length"},
      {"0.035,", "\"0.035\",", "'square_m'", "is no number"},
      {"0.026,", "0,", "'marker_m'", "0.3 to 0.95"},
      {"0.026,", "null,", "'marker_m'", "is no number"},
      {"\"first_id\": 0", "\"first_id\": -1", "'first_id'", "-1: must not be"},
      {"\"first_id\": 0", "\"first_id\": 0.5", "'first_id'", "no whole number"},
      {"DICT_4X4_250", "DICT_9X9", "'dictionary'", "DICT_9X9"},
      {"\"first_id\": 0", "\"first_id\": 203", "'dictionary'", "fewer codes"},
      {"DICT_4X4_250", "\\u001b[2J", "'dictionary'", "'?[2J'"},
      {"\"DICT_4X4_250\"", "{}", "'dictionary'", "is no text"},
      {"\"black\"", "\"grey\"", "'top_left'", "'black' or 'white'"},
      {"\"charuco\"", "\"circles\"", "'kind'", "'charuco'"},
      {"\"version\": 1", "\"version\": 2", "'version'", "must be 1"},
      {"\"format\"", "\"form\"", "'format'", "is missing"},
      {"\"kind\"", "\"kind\": \"charuco\", \"kind\"", "'kind'", "twice"},
      {"\"world\"", "\"plain\": [0, 0, 12, 8], \"x\"", "'plain'", "fewer than 8 corners"},
      {"\"world\"", "\"plain\": [2, 2, 1000000, 1], \"x\"", "'plain'", "on the sheet"},
      {"0.035,", "0.036,", "'corners'", "contradicts the layout in row 1 "},
      {"\n    [1, ", "\n    [0, ", "'corners'", "contradicts the layout in row 2 "},
      {"\n    [1, 3, 0]", "\n    [0, 3, 0]", "'markers'", "contradicts the layout in row 2 "},
      {",\n    [47, 10, 7]", "", "'markers'", "the 48 of the layout"},
      {"\"markers\": [", "\"markers\": [[], ", "'markers'", "the 48 of the layout"},
      {"metres", "metres\xff", "'world'", "not valid JSON"},
  };
  for (const Fault& fault : faults) {
    const std::string error = ReadError(Replaced(good, fault.what, fault.by));
    EXPECT_THAT(error, HasSubstr(fault.key)) << fault.by;
    EXPECT_THAT(error, HasSubstr(fault.says)) << fault.by;
    EXPECT_LT(error.size(), 600U);
    for (const char c : error) EXPECT_TRUE(c >= ' ' && c <= '~') << error;
  }
}

TEST(BoardTest, EachMissingKeyIsNamed) {
  const std::string good = Written(Board());
  for (const std::string key : {"format",
                                "version",
                                "kind",
                                "dictionary",
                                "first_id",
                                "squares",
                                "square_m",
                                "marker_m",
                                "top_left"}) {
    EXPECT_THAT(ReadError(Replaced(good, "\"" + key + "\"", "\"other\"")),
                HasSubstr("'" + key + "' is missing"));
  }
  // These are for other programs.
  for (const char* key : {"world", "corner_columns", "corners", "marker_columns", "markers"}) {
    EXPECT_EQ(ReadError(Replaced(good, "\"" + std::string(key) + "\"", "\"other\"")), "");
  }
}

TEST(BoardTest, SizesThatMakeNoSenseAreNamed) {
  Board board;
  board.square = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(CheckError(board), HasSubstr("square"));
  board = Board();
  board.marker = 0.04;
  EXPECT_THAT(CheckError(board), HasSubstr("marker"));
  board = Board();
  board.first_id = 203;
  EXPECT_THAT(CheckError(board), HasSubstr("fewer codes"));
  board = Board();
  board.plain = PlainArea{0, 0, 12, 8};
  EXPECT_THAT(CheckError(board), HasSubstr("fewer than 8 corners"));
  board.plain = PlainArea{2, 2, std::numeric_limits<int>::max(), 1};
  EXPECT_THAT(CheckError(board), HasSubstr("plain"));
}

}  // namespace
}  // namespace livemvs
