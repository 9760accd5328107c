#include "livemvs/exchange/glb.h"
#include "livemvs/exchange/glb_numbers.h"

#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "livemvs/core/error.h"
#include "livemvs/exchange/draco_mesh.h"
#include "livemvs/exchange/linear_color.h"
#include "livemvs/io/atomic_file.h"
#include "livemvs/io/little_endian.h"

namespace livemvs {
namespace {

using nlohmann::json;

// Numbers of the specification of glTF 2.0.
constexpr int kArrayBuffer = 34962, kElementArrayBuffer = 34963;
constexpr int kPoints = 0, kTriangles = 4;

/// A part of the binary chunk: its size is known before its bytes are.
struct Part {
  std::int64_t size = 0;
  std::function<void(AtomicFile&)> write;
};

/// Where positions count from: the origin, unless the model is small and far from it.
Eigen::Vector3d LocalOrigin(const ExchangeModel& model) {
  constexpr double kFar = 10;
  const Extent extent = ExtentOf(model);
  const Eigen::Vector3d center = extent.Center();
  if (center.norm() <= kFar * extent.LongestSide()) return Eigen::Vector3d::Zero();
  return center;
}

/// The turn that brings the world's up axis to y.
struct Turn {
  std::array<double, 4> quaternion;  // x y z w
  Eigen::Matrix3d matrix;
};

Turn TurnOf(UpAxis up) {
  Turn turn{{0, 0, 0, 1}, Eigen::Matrix3d::Identity()};
  if (up == UpAxis::kZ) {
    turn.quaternion = {-std::sqrt(0.5), 0, 0, std::sqrt(0.5)};
    turn.matrix << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  } else if (up == UpAxis::kMinusY) {
    turn.quaternion = {1, 0, 0, 0};
    turn.matrix << 1, 0, 0, 0, -1, 0, 0, 0, -1;
  }
  return turn;
}

Eigen::Vector3f LocalPosition(const Point& v, const Eigen::Vector3d& origin) {
  return (v.position.cast<double>() - origin).cast<float>();
}

/// Writes rows in blocks, so that no copy of the whole is needed.
template <typename Row>
void WriteRows(std::size_t count, AtomicFile& file, const Row& row) {
  constexpr std::size_t kBlock = 1 << 16;
  std::string bytes;
  for (std::size_t i = 0; i < count; ++i) {
    row(i, &bytes);
    if (bytes.size() >= kBlock || i + 1 == count) {
      file.Write(bytes);
      bytes.clear();
    }
  }
}

class GlbBuilder {
 public:
  GlbBuilder(const ExchangeModel& model, const GlbOptions& options)
      : model_(model), options_(options), origin_(LocalOrigin(model)) {
    json_["asset"] = {{"version", "2.0"}, {"generator", "livemvs"}};
    AddNode();
    json primitive = {{"mode", model.IsMesh() ? kTriangles : kPoints}};
    if (options.draco) {
      AddCompressed(&primitive);
    } else {
      AddPlain(&primitive);
    }
    if (model.IsMesh()) {
      const json matte = {{"metallicFactor", 0}, {"roughnessFactor", 1}};
      json_["materials"] = json::array({{{"pbrMetallicRoughness", matte}, {"doubleSided", true}}});
      primitive["material"] = 0;
    }
    json_["meshes"] = json::array({{{"primitives", json::array({primitive})}}});
    json_["buffers"] = json::array({{{"byteLength", size_}}});
  }

  void Write(const std::filesystem::path& path) const {
    std::string text = json_.dump();
    text.resize((text.size() + 3) / 4 * 4, ' ');
    constexpr std::int64_t kHeaders = 12 + 8 + 8;
    const std::int64_t total = kHeaders + static_cast<std::int64_t>(text.size()) + size_;
    if (total > std::numeric_limits<std::uint32_t>::max()) {
      throw Error(ErrorKind::kOutOfResource,
                  path.string() + ": GLB holds at most 4 GiB, this would take " +
                      std::to_string(total >> 20) +
                      " MiB; write .ply or .las, or fewer points (--points)");
    }
    std::string head;
    for (const std::uint32_t word : {glb::kMagic,
                                     std::uint32_t{2},
                                     static_cast<std::uint32_t>(total),
                                     static_cast<std::uint32_t>(text.size()),
                                     glb::kJsonChunk}) {
      AppendLittleEndian(&head, word);
    }
    head += text;
    AppendLittleEndian(&head, static_cast<std::uint32_t>(size_));
    AppendLittleEndian(&head, glb::kBinChunk);
    AtomicFile file(path);
    file.Write(head);
    for (const Part& part : parts_) {
      const std::int64_t begin = file.position();
      part.write(file);
      const std::int64_t rest = part.size - (file.position() - begin);
      file.Write(std::string(static_cast<std::size_t>(rest), '\0'));
    }
    file.Commit();
  }

 private:
  void AddNode() {
    const Turn turn = TurnOf(options_.up);
    json node = {{"mesh", 0}, {"name", model_.IsMesh() ? "mesh" : "cloud"}};
    if (options_.up != UpAxis::kY) node["rotation"] = turn.quaternion;
    if (!origin_.isZero(0)) {
      const Eigen::Vector3d t = turn.matrix * origin_;
      node["translation"] = {t.x(), t.y(), t.z()};
    }
    json_["scene"] = 0;
    json_["scenes"] = json::array({{{"nodes", json::array({0})}}});
    // Not {node}: compilers differ in whether that is an array.
    json_["nodes"] = json::array({node});
  }

  /// A view of the buffer, padded to four bytes.
  int AddView(std::int64_t size, int target, std::function<void(AtomicFile&)> write) {
    json view = {{"buffer", 0}, {"byteOffset", size_}, {"byteLength", size}};
    if (target != 0) view["target"] = target;
    json_["bufferViews"].push_back(view);
    const std::int64_t padded = (size + 3) / 4 * 4;
    parts_.push_back({padded, std::move(write)});
    size_ += padded;
    return static_cast<int>(json_["bufferViews"].size()) - 1;
  }

  /// @param view  Number of its view; nothing where the bytes are compressed.
  int AddAccessor(std::optional<int> view, int type, std::int64_t count, const char* shape) {
    json accessor = {{"componentType", type}, {"count", count}, {"type", shape}};
    if (view) accessor["bufferView"] = *view;
    if (type == glb::kUnsignedShort) accessor["normalized"] = true;
    json_["accessors"].push_back(accessor);
    return static_cast<int>(json_["accessors"].size()) - 1;
  }

  void AddBounds(int accessor) {
    Eigen::Vector3f low = LocalPosition(model_.vertices[0], origin_), high = low;
    for (const Point& v : model_.vertices) {
      low = low.cwiseMin(LocalPosition(v, origin_));
      high = high.cwiseMax(LocalPosition(v, origin_));
    }
    json& a = json_["accessors"][static_cast<std::size_t>(accessor)];
    a["min"] = {low.x(), low.y(), low.z()};
    a["max"] = {high.x(), high.y(), high.z()};
  }

  void AddPlain(json* primitive) {
    const std::size_t n = model_.vertices.size();
    const auto count = static_cast<std::int64_t>(n);
    const auto vectors = [&](auto value) {
      return AddView(12 * count, kArrayBuffer, [n, value](AtomicFile& file) {
        WriteRows(n, file, [&](std::size_t i, std::string* bytes) {
          const Eigen::Vector3f v = value(i);
          for (int k = 0; k < 3; ++k) AppendLittleEndian(bytes, v[k]);
        });
      });
    };
    const int positions =
        vectors([this](std::size_t i) { return LocalPosition(model_.vertices[i], origin_); });
    json& attributes = (*primitive)["attributes"];
    attributes["POSITION"] = AddAccessor(positions, glb::kFloat, count, "VEC3");
    AddBounds(attributes["POSITION"]);
    if (model_.has_normals) {
      const int normals = vectors([this](std::size_t i) { return UnitNormal(model_.vertices[i]); });
      attributes["NORMAL"] = AddAccessor(normals, glb::kFloat, count, "VEC3");
    }
    if (model_.has_colors) {
      attributes["COLOR_0"] = AddAccessor(AddColors(), glb::kUnsignedShort, count, "VEC4");
    }
    if (model_.IsMesh()) AddIndices(primitive);
  }

  int AddColors() {
    const std::size_t n = model_.vertices.size();
    return AddView(8 * static_cast<std::int64_t>(n), kArrayBuffer, [this, n](AtomicFile& file) {
      WriteRows(n, file, [&](std::size_t i, std::string* bytes) {
        for (const std::uint8_t c : model_.vertices[i].color) {
          AppendLittleEndian(bytes, LinearFromSrgb(c));
        }
        AppendLittleEndian(bytes, std::uint16_t{65535});
      });
    });
  }

  void AddIndices(json* primitive) {
    const std::size_t n = model_.faces.size();
    const auto count = 3 * static_cast<std::int64_t>(n);
    const int view = AddView(4 * count, kElementArrayBuffer, [this, n](AtomicFile& file) {
      WriteRows(n, file, [&](std::size_t i, std::string* bytes) {
        for (int k = 0; k < 3; ++k) {
          AppendLittleEndian(bytes, static_cast<std::uint32_t>(model_.faces[i][k]));
        }
      });
    });
    (*primitive)["indices"] = AddAccessor(view, glb::kUnsignedInt, count, "SCALAR");
  }

  void AddCompressed(json* primitive) {
    DracoMesh mesh = CompressMesh(model_, origin_, options_.position_bits);
    json ids = {{"POSITION", mesh.position_id}};
    json& attributes = (*primitive)["attributes"];
    attributes["POSITION"] = AddAccessor({}, glb::kFloat, mesh.points, "VEC3");
    AddBounds(attributes["POSITION"]);
    if (mesh.normal_id >= 0) {
      ids["NORMAL"] = mesh.normal_id;
      attributes["NORMAL"] = AddAccessor({}, glb::kFloat, mesh.points, "VEC3");
    }
    if (mesh.color_id >= 0) {
      ids["COLOR_0"] = mesh.color_id;
      attributes["COLOR_0"] = AddAccessor({}, glb::kUnsignedShort, mesh.points, "VEC4");
    }
    (*primitive)["indices"] = AddAccessor({}, glb::kUnsignedInt, 3 * mesh.faces, "SCALAR");
    const auto size = static_cast<std::int64_t>(mesh.bytes.size());
    const int view =
        AddView(size, 0, [bytes = std::move(mesh.bytes)](AtomicFile& file) { file.Write(bytes); });
    const char* kExtension = "KHR_draco_mesh_compression";
    (*primitive)["extensions"][kExtension] = {{"bufferView", view}, {"attributes", ids}};
    json_["extensionsUsed"] = json::array({kExtension});
    json_["extensionsRequired"] = json::array({kExtension});
  }

  const ExchangeModel& model_;
  const GlbOptions options_;
  const Eigen::Vector3d origin_;
  json json_;
  std::vector<Part> parts_;
  std::int64_t size_ = 0;  ///< Of the parts.
};

}  // namespace

void WriteGlb(const std::filesystem::path& path,
              const ExchangeModel& model,
              const GlbOptions& options) {
  model.Check();
  if (options.draco && !model.IsMesh()) {
    throw std::invalid_argument(
        "--draco: glTF's Draco extension compresses meshes only, and this is a cloud; leave it "
        "out, or thin the cloud (--points)");
  }
  if (options.position_bits < 8 || options.position_bits > 24) {
    throw std::invalid_argument("position_bits: " + std::to_string(options.position_bits) +
                                " is not within 8 ... 24");
  }
  GlbBuilder(model, options).Write(path);
}

}  // namespace livemvs
