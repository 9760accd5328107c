#include <Eigen/Geometry>
#include <array>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <system_error>

#include "livemvs/core/error.h"
#include "livemvs/exchange/glb.h"
#include "livemvs/exchange/glb_numbers.h"
#include "livemvs/exchange/linear_color.h"
#include "livemvs/io/little_endian.h"

namespace livemvs {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// The bytes of an accessor, which are all there.
struct Rows {
  std::string_view bytes;
  std::size_t count = 0;

  template <typename T>
  T At(std::size_t index) const {
    return FromLittleEndian<T>(bytes.data() + index * sizeof(T));
  }
};

/// Form of an accessor's rows.
struct Form {
  std::uint64_t component;
  const char* shape;
  std::size_t row_bytes;
};
constexpr Form kVectors{glb::kFloat, "VEC3", 12}, kColors{glb::kUnsignedShort, "VEC4", 8},
    kIndices{glb::kUnsignedInt, "SCALAR", 4};

class GlbReader {
 public:
  GlbReader(std::string_view bytes, const std::string& place) : place_(place) {
    constexpr std::size_t kHeader = 12;
    if (bytes.size() < kHeader || FromLittleEndian<std::uint32_t>(bytes.data()) != glb::kMagic ||
        FromLittleEndian<std::uint32_t>(bytes.data() + 4) != 2) {
      Refuse("is not a GLB file (binary glTF 2.0)");
    }
    if (FromLittleEndian<std::uint32_t>(bytes.data() + 8) != bytes.size()) {
      Refuse("is not as long as its header says; it may be cut short");
    }
    bytes.remove_prefix(kHeader);
    const std::string_view text = TakeChunk(glb::kJsonChunk, &bytes);
    binary_ = TakeChunk(glb::kBinChunk, &bytes);
    json_ = json::parse(text);
  }

  ExchangeModel Read() const {
    if (json_.at("asset").value("generator", "") != "livemvs") {
      Refuse(
          "was written by another program; of GLB livemvs reads back its own: convert it to PLY");
    }
    const json& primitive = json_.at("meshes").at(0).at("primitives").at(0);
    if (primitive.contains("extensions")) {
      Refuse("is compressed (Draco), which livemvs does not read back; write it without --draco");
    }
    const json& attributes = primitive.at("attributes");
    ExchangeModel model;
    ReadPositions(attributes.at("POSITION"), &model);
    if (attributes.contains("NORMAL")) ReadNormals(attributes.at("NORMAL"), &model);
    if (attributes.contains("COLOR_0")) ReadColors(attributes.at("COLOR_0"), &model);
    if (primitive.contains("indices")) ReadFaces(primitive.at("indices"), &model);
    return model;
  }

 private:
  [[noreturn]] void Refuse(const std::string& what) const { throw BadInput(place_ + ": " + what); }

  std::string_view TakeChunk(std::uint32_t type, std::string_view* bytes) const {
    constexpr std::size_t kHead = 8;
    if (bytes->size() < kHead ||
        FromLittleEndian<std::uint32_t>(bytes->data()) > bytes->size() - kHead ||
        FromLittleEndian<std::uint32_t>(bytes->data() + 4) != type) {
      Refuse("its chunks are not those of a GLB file");
    }
    const std::size_t size = FromLittleEndian<std::uint32_t>(bytes->data());
    const std::string_view chunk = bytes->substr(kHead, size);
    bytes->remove_prefix(kHead + size);
    return chunk;
  }

  std::uint64_t Whole(const json& number) const {
    if (!number.is_number_unsigned()) Refuse("a count or place in it is no whole number");
    return number.get<std::uint64_t>();
  }

  Rows RowsOf(const json& accessor_number, const Form& form) const {
    const json& accessor = json_.at("accessors").at(Whole(accessor_number));
    const json& view = json_.at("bufferViews").at(Whole(accessor.at("bufferView")));
    const std::uint64_t count = Whole(accessor.at("count"));
    const std::uint64_t begin = Whole(view.at("byteOffset"));
    const std::uint64_t size = Whole(view.at("byteLength"));
    if (Whole(accessor.at("componentType")) != form.component ||
        accessor.at("type").get<std::string>() != form.shape) {
      Refuse("its numbers are not of the kind that livemvs writes");
    }
    if (begin > binary_.size() || size > binary_.size() - begin || count > size / form.row_bytes) {
      Refuse("names more vertices or faces than it holds");
    }
    return {binary_.substr(begin, count * form.row_bytes), count};
  }

  Rows RowsForVertices(const json& number, const Form& form, const ExchangeModel& model) const {
    const Rows rows = RowsOf(number, form);
    if (rows.count != model.vertices.size()) Refuse("has not one normal and colour per vertex");
    return rows;
  }

  static Eigen::Vector3f VectorAt(const Rows& rows, std::size_t i) {
    return {rows.At<float>(3 * i), rows.At<float>(3 * i + 1), rows.At<float>(3 * i + 2)};
  }

  /// Where positions count from, in the world that was written: what the node's turn leaves of it.
  Eigen::Vector3d Origin() const {
    const json& node = json_.at("nodes").at(0);
    Eigen::Vector3d origin = Eigen::Vector3d::Zero();
    if (!node.contains("translation")) return origin;
    const auto t = node.at("translation").get<std::array<double, 3>>();
    origin = {t[0], t[1], t[2]};
    if (node.contains("rotation")) {
      const auto q = node.at("rotation").get<std::array<double, 4>>();
      origin = Eigen::Quaterniond(q[3], q[0], q[1], q[2]).conjugate() * origin;
    }
    return origin;
  }

  void ReadPositions(const json& number, ExchangeModel* model) const {
    const Rows rows = RowsOf(number, kVectors);
    if (rows.count == 0) Refuse("holds no vertex");
    const Eigen::Vector3d origin = Origin();
    model->vertices.resize(rows.count);
    for (std::size_t i = 0; i < rows.count; ++i) {
      Eigen::Vector3f& p = model->vertices[i].position;
      p = (VectorAt(rows, i).cast<double>() + origin).cast<float>();
      if (!p.allFinite()) Refuse("a position is not finite");
    }
  }

  void ReadNormals(const json& number, ExchangeModel* model) const {
    const Rows rows = RowsForVertices(number, kVectors, *model);
    for (std::size_t i = 0; i < rows.count; ++i) {
      const Eigen::Vector3f n = VectorAt(rows, i);
      if (n.allFinite()) model->vertices[i].normal = n;
    }
    model->has_normals = true;
  }

  void ReadColors(const json& number, ExchangeModel* model) const {
    const Rows rows = RowsForVertices(number, kColors, *model);
    for (std::size_t i = 0; i < rows.count; ++i) {
      for (std::size_t k = 0; k < 3; ++k) {
        model->vertices[i].color[k] = SrgbFromLinear(rows.At<std::uint16_t>(4 * i + k));
      }
    }
    model->has_colors = true;
  }

  void ReadFaces(const json& number, ExchangeModel* model) const {
    const Rows rows = RowsOf(number, kIndices);
    if (rows.count % 3 != 0) Refuse("its faces are not triangles");
    model->faces.resize(rows.count / 3);
    for (std::size_t i = 0; i < model->faces.size(); ++i) {
      for (int k = 0; k < 3; ++k) {
        const auto vertex = rows.At<std::uint32_t>(3 * i + static_cast<std::size_t>(k));
        if (vertex >= model->vertices.size()) Refuse("a face names a vertex that does not exist");
        model->faces[i][k] = static_cast<int>(vertex);
      }
    }
  }

  std::string place_;
  std::string_view binary_;
  json json_;
};

std::string BytesOf(const fs::path& path) {
  std::error_code error;
  if (fs::is_directory(path, error)) throw BadInput(path.string() + ": is a directory");
  std::ifstream file(path, std::ios::binary);
  if (!file) throw BadInput(path.string() + ": cannot be opened: " + std::strerror(errno));
  const std::uintmax_t size = fs::file_size(path, error);
  if (error) throw BadInput(path.string() + ": cannot be read: " + error.message());
  std::string bytes(size, '\0');
  file.read(bytes.data(), static_cast<std::streamsize>(size));
  bytes.resize(static_cast<std::size_t>(file.gcount()));
  return bytes;
}

}  // namespace

ExchangeModel ReadGlb(const fs::path& path) {
  const std::string bytes = BytesOf(path);
  try {
    return GlbReader(bytes, path.string()).Read();
  } catch (const json::exception& e) {
    throw BadInput(path.string() + ": its description is damaged (" + e.what() + ")");
  }
}

}  // namespace livemvs
