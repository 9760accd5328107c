#include <charconv>
#include <limits>
#include <map>
#include <sstream>
#include <system_error>

#include "livemvs/io/ply_stream.h"

namespace livemvs::ply {
namespace {

constexpr int kMaxLines = 10'000;
constexpr std::size_t kMaxElements = 64;
constexpr std::size_t kMaxProperties = 512;

Type ParseType(const ByteStream& in, const std::string& name) {
  static const std::map<std::string, Type> kTypes = {{"char", Type::kInt8},
                                                     {"int8", Type::kInt8},
                                                     {"uchar", Type::kUint8},
                                                     {"uint8", Type::kUint8},
                                                     {"short", Type::kInt16},
                                                     {"int16", Type::kInt16},
                                                     {"ushort", Type::kUint16},
                                                     {"uint16", Type::kUint16},
                                                     {"int", Type::kInt32},
                                                     {"int32", Type::kInt32},
                                                     {"uint", Type::kUint32},
                                                     {"uint32", Type::kUint32},
                                                     {"float", Type::kFloat32},
                                                     {"float32", Type::kFloat32},
                                                     {"double", Type::kFloat64},
                                                     {"float64", Type::kFloat64}};
  const auto found = kTypes.find(name);
  if (found == kTypes.end()) throw in.Damaged("unknown property type '" + name + "'");
  return found->second;
}

Format ParseFormat(const ByteStream& in, const std::string& name) {
  if (name == "ascii") return Format::kAscii;
  if (name == "binary_little_endian") return Format::kLittleEndian;
  if (name == "binary_big_endian") return Format::kBigEndian;
  throw in.Damaged("unknown PLY format '" + name + "'");
}

Element ParseElement(const ByteStream& in, std::istringstream& words) {
  Element element;
  std::string count;
  words >> element.name >> count;
  const auto [end, error] =
      std::from_chars(count.data(), count.data() + count.size(), element.count);
  if (count.empty() || error != std::errc() || end != count.data() + count.size() ||
      element.count < 0) {
    throw in.Damaged("the number of '" + element.name + "' rows, '" + count + "', is not a count");
  }
  return element;
}

Property ParseProperty(const ByteStream& in, std::istringstream& words) {
  Property property;
  std::string type;
  words >> type;
  if (type == "list") {
    property.is_list = true;
    std::string count_type;
    words >> count_type >> type;
    property.count_type = ParseType(in, count_type);
    if (IsFloat(property.count_type)) throw in.Damaged("the length of a list must be an integer");
  }
  property.type = ParseType(in, type);
  words >> property.name;
  if (property.name.empty()) throw in.Damaged("a property has no name");
  return property;
}

void AddProperty(const ByteStream& in, Element& element, Property property) {
  if (element.properties.size() == kMaxProperties) throw in.Damaged("too many properties");
  for (const Property& other : element.properties) {
    if (other.name == property.name) {
      throw in.Damaged("the property '" + property.name + "' is there twice");
    }
  }
  element.properties.push_back(std::move(property));
}

/// The fewest bytes that a row can take.
std::int64_t LeastRowBytes(const Element& element, Format format) {
  std::int64_t bytes = 0;
  for (const Property& property : element.properties) {
    // In ascii, a digit and a space.
    const Type type = property.is_list ? property.count_type : property.type;
    bytes += format == Format::kAscii ? 2 : SizeOf(type);
  }
  return bytes;
}

void CheckCounts(const ByteStream& in, const Header& header) {
  std::int64_t left = in.MostBytesLeft() + 1;  // The last line of ascii may lack its end.
  for (const Element& element : header.elements) {
    const std::int64_t row = LeastRowBytes(element, header.format);
    if (row > 0 && element.count > left / row) {
      throw in.Damaged("the header promises " + std::to_string(element.count) + " '" +
                       element.name +
                       "' rows, more than the file can hold; it is cut short or "
                       "damaged, copy it again");
    }
    left -= row * element.count;
  }
}

void ParseLine(const ByteStream& in, const std::string& line, Header* header, bool* has_format) {
  std::istringstream words(line);
  std::string keyword;
  words >> keyword;
  if (keyword == "format") {
    std::string name;
    words >> name;
    header->format = ParseFormat(in, name);
    *has_format = true;
  } else if (keyword == "comment") {
    header->comments.push_back(line.size() > 8 ? line.substr(8) : "");
  } else if (keyword == "element") {
    if (header->elements.size() == kMaxElements) throw in.Damaged("too many elements");
    header->elements.push_back(ParseElement(in, words));
  } else if (keyword == "property") {
    if (header->elements.empty()) throw in.Damaged("a property stands before the first element");
    AddProperty(in, header->elements.back(), ParseProperty(in, words));
  } else if (keyword != "obj_info" && !keyword.empty()) {
    throw in.Damaged("unknown header line '" + line.substr(0, 60) + "'");
  }
}

}  // namespace

Header ReadHeader(ByteStream& in) {
  char magic[3];
  in.Read(magic, 3);
  const int after = in.Get();
  if (std::string_view(magic, 3) != "ply" || (after != '\n' && after != '\r')) {
    throw in.Damaged("is no PLY file (its first line is not 'ply')");
  }
  if (after == '\r' && in.Get() != '\n') {
    throw in.Damaged("its header lines end as on old Macintoshes, which is not supported");
  }
  Header header;
  bool has_format = false;
  for (int i = 0; i < kMaxLines; ++i) {
    const std::string line = in.Line();
    if (line == "end_header") {
      if (!has_format) throw in.Damaged("the header has no format line");
      CheckCounts(in, header);
      return header;
    }
    ParseLine(in, line, &header, &has_format);
  }
  throw in.Damaged("the header has more than 10000 lines");
}

}  // namespace livemvs::ply
