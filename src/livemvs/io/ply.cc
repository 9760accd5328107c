#include "livemvs/io/ply.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "livemvs/io/ply_stream.h"

namespace livemvs {
namespace {

using ply::ByteStream;
using ply::Element;
using ply::Format;
using ply::Header;
using ply::Property;

constexpr int kMaxPolygon = 10'000;

/// What a vertex property means to us.
enum class Field {
  kNone,
  kX,
  kY,
  kZ,
  kNx,
  kNy,
  kNz,
  kRed,
  kGreen,
  kBlue,
  kSigma,
  kRatio,
  kViews,
  kFrame
};

Field FieldOf(const std::string& name) {
  static constexpr std::pair<const char*, Field> kNames[] = {{"x", Field::kX},
                                                             {"y", Field::kY},
                                                             {"z", Field::kZ},
                                                             {"nx", Field::kNx},
                                                             {"ny", Field::kNy},
                                                             {"nz", Field::kNz},
                                                             {"red", Field::kRed},
                                                             {"green", Field::kGreen},
                                                             {"blue", Field::kBlue},
                                                             {"r", Field::kRed},
                                                             {"g", Field::kGreen},
                                                             {"b", Field::kBlue},
                                                             {"diffuse_red", Field::kRed},
                                                             {"diffuse_green", Field::kGreen},
                                                             {"diffuse_blue", Field::kBlue},
                                                             {"sigma", Field::kSigma},
                                                             {"inlier_ratio", Field::kRatio},
                                                             {"views", Field::kViews},
                                                             {"frame", Field::kFrame}};
  for (const auto& [known, field] : kNames) {
    if (name == known) return field;
  }
  return Field::kNone;
}

float ToFloat(double value) {
  // Beyond float's range counts as not finite.
  constexpr double kMax = std::numeric_limits<float>::max();
  return std::abs(value) <= kMax ? static_cast<float>(value)
                                 : std::numeric_limits<float>::infinity();
}

float FiniteOrZero(double value) {
  const float narrow = ToFloat(value);
  return std::isfinite(narrow) ? narrow : 0.0f;
}

/// Bytes as they are; 16 bits are scaled down, real numbers span 0 ... 1.
std::uint8_t ToColor(double value, ply::Type type) {
  if (ply::IsFloat(type)) value *= 255;
  if (type == ply::Type::kUint16) value /= 257;
  return value > 0 ? static_cast<std::uint8_t>(std::lround(std::min(value, 255.0))) : 0;
}

void SetField(Point* point, Field field, double value, ply::Type type) {
  switch (field) {
    case Field::kX:
    case Field::kY:
    case Field::kZ:
      point->position[static_cast<int>(field) - static_cast<int>(Field::kX)] = ToFloat(value);
      break;
    case Field::kNx:
    case Field::kNy:
    case Field::kNz:
      point->normal[static_cast<int>(field) - static_cast<int>(Field::kNx)] = FiniteOrZero(value);
      break;
    case Field::kRed:
    case Field::kGreen:
    case Field::kBlue:
      point->color[static_cast<std::size_t>(field) - static_cast<std::size_t>(Field::kRed)] =
          ToColor(value, type);
      break;
    case Field::kSigma:
      point->sigma = FiniteOrZero(value);
      break;
    case Field::kRatio:
      point->inlier_ratio = FiniteOrZero(value);
      break;
    case Field::kViews:
      point->views = value > 0 ? static_cast<std::uint16_t>(std::min(value, 65535.0)) : 0;
      break;
    case Field::kFrame:
      point->frame = value >= 0 && value <= std::numeric_limits<std::int32_t>::max()
                         ? static_cast<std::int32_t>(value)
                         : -1;
      break;
    case Field::kNone:
      break;
  }
}

bool Has(const std::vector<Field>& fields, std::initializer_list<Field> wanted) {
  return std::ranges::all_of(wanted, [&](Field f) { return std::ranges::count(fields, f) > 0; });
}

std::vector<Field> FieldsOf(const ByteStream& in, const Element& element) {
  std::vector<Field> fields;
  for (const Property& property : element.properties) {
    if (property.is_list) {
      throw in.Damaged("the vertex property '" + property.name +
                       "' is a list, which is not supported; export the file without it");
    }
    fields.push_back(FieldOf(property.name));
  }
  if (!Has(fields, {Field::kX, Field::kY, Field::kZ})) {
    throw in.Damaged("the vertices lack x, y or z");
  }
  return fields;
}

class Reader {
 public:
  Reader(const std::filesystem::path& path, const PlyReadOptions& options)
      : in_(path, options.max_unpacked_bytes) {}

  PlyContents Read() {
    Header header = ply::ReadHeader(in_);
    format_ = header.format;
    contents_.comments = std::move(header.comments);
    bool has_vertices = false;
    for (const Element& element : header.elements) {
      if (element.name == "vertex" && !has_vertices) {
        has_vertices = true;
        ReadVertices(element);
      } else if (element.name == "face") {
        ReadFaces(element);
      } else {
        for (std::int64_t i = 0; i < element.count && !element.properties.empty(); ++i) {
          for (const Property& property : element.properties) SkipProperty(property);
        }
      }
    }
    if (!has_vertices) throw in_.Damaged("the file has no vertices");
    RenumberFaces();
    return std::move(contents_);
  }

 private:
  void ReadVertices(const Element& element) {
    const std::vector<Field> fields = FieldsOf(in_, element);
    contents_.has_normals = Has(fields, {Field::kNx, Field::kNy, Field::kNz});
    contents_.has_colors = Has(fields, {Field::kRed, Field::kGreen, Field::kBlue});
    // Beyond this the cloud grows with the rows that are there, whatever the header says.
    constexpr std::int64_t kMostReserved = 1 << 20;
    contents_.cloud.reserve(static_cast<std::size_t>(std::min(element.count, kMostReserved)));
    for (std::int64_t i = 0; i < element.count; ++i) {
      Point point;
      for (std::size_t k = 0; k < fields.size(); ++k) {
        const ply::Type type = element.properties[k].type;
        SetField(&point, fields[k], ply::ReadNumber(in_, format_, type), type);
      }
      if (point.position.allFinite()) {
        contents_.cloud.push_back(point);
      } else {
        dropped_.push_back(i);
      }
    }
    vertex_count_ = element.count;
    contents_.dropped_vertices = static_cast<std::int64_t>(dropped_.size());
  }

  void ReadFaces(const Element& element) {
    for (std::int64_t i = 0; i < element.count; ++i) {
      if (element.properties.empty()) break;
      for (const Property& property : element.properties) {
        if (property.is_list &&
            (property.name == "vertex_indices" || property.name == "vertex_index")) {
          ReadPolygon(property, i);
        } else {
          SkipProperty(property);
        }
      }
    }
  }

  void ReadPolygon(const Property& property, std::int64_t face) {
    const double count = ply::ReadNumber(in_, format_, property.count_type);
    if (!(count >= 0 && count <= kMaxPolygon)) {
      throw in_.Damaged("face " + std::to_string(face) + " has an impossible number of corners");
    }
    int first = 0, before = 0;
    for (int i = 0; i < static_cast<int>(count); ++i) {
      const double value = ply::ReadNumber(in_, format_, property.type);
      if (!(value >= 0 && value < std::numeric_limits<int>::max()) || value != std::floor(value)) {
        throw in_.Damaged("face " + std::to_string(face) + " names an impossible vertex");
      }
      const int index = static_cast<int>(value);
      if (i >= 2) contents_.faces.emplace_back(first, before, index);
      if (i == 0) first = index;
      before = index;
    }
  }

  void SkipProperty(const Property& property) {
    double count = 1;
    if (property.is_list) count = ply::ReadNumber(in_, format_, property.count_type);
    if (!(count >= 0 && count <= 4294967295.0)) {
      throw in_.Damaged("a list of '" + property.name + "' has an impossible length");
    }
    const auto items = static_cast<std::int64_t>(count);
    if (format_ != Format::kAscii) return in_.Skip(items * ply::SizeOf(property.type));
    for (std::int64_t i = 0; i < items; ++i) in_.Word();
  }

  /// Checks the faces against the vertices, and renumbers them where some were left out.
  void RenumberFaces() {
    std::size_t kept = 0;
    for (Eigen::Vector3i face : contents_.faces) {
      if (face.maxCoeff() >= vertex_count_) {
        throw in_.Damaged("a face names vertex " + std::to_string(face.maxCoeff()) +
                          ", but there are only " + std::to_string(vertex_count_));
      }
      bool complete = true;
      for (int& index : face) {
        const auto at = std::ranges::lower_bound(dropped_, index);
        if (at != dropped_.end() && *at == index) complete = false;
        index -= static_cast<int>(at - dropped_.begin());
      }
      if (complete) contents_.faces[kept++] = face;
    }
    contents_.dropped_faces = static_cast<std::int64_t>(contents_.faces.size() - kept);
    contents_.faces.resize(kept);
  }

  ByteStream in_;
  Format format_ = Format::kAscii;
  PlyContents contents_;
  std::int64_t vertex_count_ = 0;      ///< In the file.
  std::vector<std::int64_t> dropped_;  ///< Rows of vertices that were left out, ascending.
};

}  // namespace

PlyContents ReadPly(const std::filesystem::path& path, const PlyReadOptions& options) {
  return Reader(path, options).Read();
}

TriangleMesh ReadMeshPly(const std::filesystem::path& path, const PlyReadOptions& options) {
  const PlyContents contents = ReadPly(path, options);
  if (contents.faces.empty()) {
    throw BadInput(path.string() + ": holds no faces, so it is a cloud and no mesh");
  }
  return MeshOf(contents.cloud, contents.faces, contents.has_colors);
}

TriangleMesh MeshOf(const PointCloud& vertices,
                    std::vector<Eigen::Vector3i> faces,
                    bool with_colors) {
  TriangleMesh mesh;
  mesh.faces = std::move(faces);
  mesh.vertices.reserve(vertices.size());
  for (const Point& vertex : vertices) {
    mesh.vertices.push_back(vertex.position);
    if (with_colors) mesh.colors.push_back(vertex.color);
  }
  return mesh;
}

}  // namespace livemvs
