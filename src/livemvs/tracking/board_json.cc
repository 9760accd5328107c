// The description of a sheet as a file.

#include <cmath>
#include <map>

#include "livemvs/core/error.h"
#include "livemvs/io/atomic_file.h"
#include "livemvs/io/dataset_text.h"
#include "livemvs/io/json_file.h"
#include "livemvs/tracking/board.h"
#include "livemvs/tracking/board_flaw.h"

namespace livemvs {
namespace {

using nlohmann::json;

constexpr char kFormat[] = "livemvs board";
constexpr int kVersion = 1;
constexpr double kLayoutTolerance = 1e-6;  // of the corners as written [m]

JsonLimits Limits() {
  // A sheet of 200 x 200 squares takes 4 MB and needs a depth of 3.
  return {.max_bytes = std::size_t{16} << 20,
          .max_depth = 16,
          .unique_keys = true,
          .what = "description of 'livemvs board'"};
}

// Reads fields with the file's name in every message.
class Fields {
 public:
  Fields(const json& object, std::string file) : object_(object), file_(std::move(file)) {}

  template <typename T>
  T Get(const char* name) const {
    if (!object_.contains(name)) Fail(name, "is missing");
    return As<T>(object_[name], name);
  }

  std::vector<int> Integers(const char* name, std::size_t count) const {
    if (!object_.contains(name)) Fail(name, "is missing");
    const json& list = object_[name];
    if (!list.is_array() || list.size() != count) {
      Fail(name, "must be a list of " + std::to_string(count) + " whole numbers");
    }
    std::vector<int> values;
    for (const json& value : list) values.push_back(As<int>(value, name));
    return values;
  }

  [[noreturn]] void Fail(const std::string& name, const std::string& what) const {
    throw BadInput(file_ + ": '" + name + "' " + what +
                   "; make the description anew with 'livemvs board'");
  }

 private:
  template <typename T>
  T As(const json& value, const char* name) const {
    if constexpr (std::is_same_v<T, std::string>) {
      if (!value.is_string()) Fail(name, "is no text");
    } else if constexpr (std::is_same_v<T, int>) {
      // Out of int's range is out of any sheet's.
      if (!value.is_number_integer() || std::abs(value.get<double>()) > 1e6) {
        Fail(name, "is no whole number of a sensible size");
      }
    } else {
      if (!value.is_number()) Fail(name, "is no number");
    }
    return value.get<T>();
  }

  const json& object_;
  std::string file_;
};

// A list of lists of numbers, where the file has it, must be what follows from the layout.
void CheckAsWritten(const json& root,
                    const char* name,
                    const std::vector<std::vector<double>>& rows,
                    const Fields& fields) {
  if (!root.contains(name)) return;
  const json& written = root[name];
  if (!written.is_array() || written.size() != rows.size()) {
    fields.Fail(name, "must be a list of the " + std::to_string(rows.size()) + " of the layout");
  }
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const json& row = written[i];
    bool same = row.is_array() && row.size() == rows[i].size();
    for (std::size_t k = 0; same && k < rows[i].size(); ++k) {
      same = row[k].is_number() && std::abs(row[k].get<double>() - rows[i][k]) <= kLayoutTolerance;
    }
    if (!same) {
      fields.Fail(name, "contradicts the layout in row " + std::to_string(i + 1) + " of the list");
    }
  }
}

void CheckListsAsWritten(const json& root, const Board& board, const Fields& fields) {
  std::vector<std::vector<double>> corners, markers;
  for (const BoardCorner& c : CornersOf(board)) {
    corners.push_back({static_cast<double>(c.id), c.point.x(), c.point.y(), c.point.z()});
  }
  for (const BoardMarker& m : MarkersOf(board)) {
    markers.push_back(
        {static_cast<double>(m.id), static_cast<double>(m.column), static_cast<double>(m.row)});
  }
  CheckAsWritten(root, "corners", corners, fields);
  CheckAsWritten(root, "markers", markers, fields);
}

// What a field of Board is called in the file.
std::string KeyOf(const std::string& field) {
  static const std::map<std::string, std::string> keys = {
      {"columns", "squares"}, {"rows", "squares"}, {"square", "square_m"}, {"marker", "marker_m"}};
  const auto found = keys.find(field);
  return found == keys.end() ? field : found->second;
}

Board Interpret(const json& root, const std::filesystem::path& file) {
  const Fields fields(root, file.string());
  if (fields.Get<std::string>("format") != kFormat) {
    fields.Fail("format", "must be '" + std::string(kFormat) + "'");
  }
  if (fields.Get<int>("version") != kVersion) {
    fields.Fail("version", "must be " + std::to_string(kVersion));
  }
  if (fields.Get<std::string>("kind") != "charuco") fields.Fail("kind", "must be 'charuco'");
  Board board;
  const std::vector<int> squares = fields.Integers("squares", 2);
  board.columns = squares[0];
  board.rows = squares[1];
  board.square = fields.Get<double>("square_m");
  board.marker = fields.Get<double>("marker_m");
  board.dictionary = fields.Get<std::string>("dictionary");
  board.first_id = fields.Get<int>("first_id");
  const std::string top_left = fields.Get<std::string>("top_left");
  if (top_left != "black" && top_left != "white") {
    fields.Fail("top_left", "must be 'black' or 'white'");
  }
  board.top_left_black = top_left == "black";
  if (root.contains("plain")) {
    const std::vector<int> plain = fields.Integers("plain", 4);
    board.plain = PlainArea{plain[0], plain[1], plain[2], plain[3]};
  }
  try {
    board.Check();
  } catch (const BoardFlaw& flaw) {
    fields.Fail(KeyOf(flaw.field), flaw.what_is_wrong);
  }
  CheckListsAsWritten(root, board, fields);
  return board;
}

std::string Exact(double value) { return json(value).dump(); }

// A list of lists, one of them a line.
std::string Rows(const char* name, const std::vector<std::string>& rows) {
  std::string text = std::string("  \"") + name + "\": [";
  for (std::size_t i = 0; i < rows.size(); ++i)
    text += (i ? ",\n    [" : "\n    [") + rows[i] + "]";
  return text + "\n  ]";
}

}  // namespace

Board ReadBoard(const std::filesystem::path& file) {
  const json root = ReadJsonFile(file, Limits());
  if (!root.is_object()) {
    throw BadInput(file.string() + ": no JSON object; this is no description of 'livemvs board'");
  }
  return Interpret(root, file);
}

void WriteBoard(const std::filesystem::path& file, const Board& board) {
  board.Check();
  std::vector<std::string> corners, markers;
  for (const BoardCorner& c : CornersOf(board)) {
    corners.push_back(std::to_string(c.id) + ", " + Exact(c.point.x()) + ", " + Exact(c.point.y()) +
                      ", 0.0");
  }
  for (const BoardMarker& m : MarkersOf(board)) {
    markers.push_back(std::to_string(m.id) + ", " + std::to_string(m.column) + ", " +
                      std::to_string(m.row));
  }
  std::string text = "{\n  \"format\": \"" + std::string(kFormat) + "\",\n  \"version\": 1,\n";
  text += "  \"kind\": \"charuco\",\n  \"dictionary\": \"" + board.dictionary + "\",\n";
  text += "  \"first_id\": " + std::to_string(board.first_id) + ",\n";
  text += "  \"squares\": [" + std::to_string(board.columns) + ", " + std::to_string(board.rows) +
          "],\n";
  text += "  \"square_m\": " + Exact(board.square) + ",\n";
  text += "  \"marker_m\": " + Exact(board.marker) + ",\n";
  text += std::string("  \"top_left\": \"") + (board.top_left_black ? "black" : "white") + "\",\n";
  if (board.plain) {
    const PlainArea& p = *board.plain;
    text += "  \"plain\": [" + std::to_string(p.column) + ", " + std::to_string(p.row) + ", " +
            std::to_string(p.columns) + ", " + std::to_string(p.rows) + "],\n";
  }
  text +=
      "  \"world\": \"metres; origin in the middle of the squares, x right and y up on the sheet, "
      "z towards the objects\",\n";
  text += "  \"corner_columns\": [\"id\", \"x_m\", \"y_m\", \"z_m\"],\n" + Rows("corners", corners);
  text += ",\n  \"marker_columns\": [\"id\", \"column\", \"row\"],\n" + Rows("markers", markers);
  AtomicFile out(file);
  out.Write(text + "\n}\n");
  out.Commit();
}

}  // namespace livemvs
