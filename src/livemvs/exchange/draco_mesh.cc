#include "livemvs/exchange/draco_mesh.h"

#include <draco/compression/expert_encode.h>
#include <draco/core/encoder_buffer.h>
#include <draco/mesh/mesh.h>

#include <array>
#include <memory>

#include "livemvs/core/error.h"
#include "livemvs/exchange/linear_color.h"

namespace livemvs {
namespace {

constexpr int kNormalBits = 10;  // octahedral: 0.1 degrees

/// Adds an attribute whose value belongs to the vertex of the same number.
/// @return Its number in the mesh, for the encoder's options.
int AddAttribute(draco::GeometryAttribute::Type type,
                 draco::DataType data_type,
                 int components,
                 bool normalized,
                 std::size_t count,
                 draco::Mesh* mesh) {
  draco::GeometryAttribute attribute;
  const auto size = static_cast<std::int64_t>(components) * draco::DataTypeLength(data_type);
  attribute.Init(
      type, nullptr, static_cast<std::int8_t>(components), data_type, normalized, size, 0);
  return mesh->AddAttribute(attribute, true, static_cast<std::uint32_t>(count));
}

struct Attributes {
  int position = -1, normal = -1, color = -1;
};

Attributes FillMesh(const ExchangeModel& model, const Eigen::Vector3d& origin, draco::Mesh* mesh) {
  const std::size_t count = model.vertices.size();
  mesh->set_num_points(static_cast<std::uint32_t>(count));
  mesh->SetNumFaces(model.faces.size());
  using Type = draco::GeometryAttribute;
  Attributes ids;
  ids.position = AddAttribute(Type::POSITION, draco::DT_FLOAT32, 3, false, count, mesh);
  if (model.has_normals) {
    ids.normal = AddAttribute(Type::NORMAL, draco::DT_FLOAT32, 3, false, count, mesh);
  }
  if (model.has_colors) {
    ids.color = AddAttribute(Type::COLOR, draco::DT_UINT16, 4, true, count, mesh);
  }
  for (std::size_t i = 0; i < count; ++i) {
    const Point& v = model.vertices[i];
    const draco::AttributeValueIndex index(static_cast<std::uint32_t>(i));
    const Eigen::Vector3f position = (v.position.cast<double>() - origin).cast<float>();
    mesh->attribute(ids.position)->SetAttributeValue(index, position.data());
    if (ids.normal >= 0) {
      const Eigen::Vector3f normal = UnitNormal(v);
      mesh->attribute(ids.normal)->SetAttributeValue(index, normal.data());
    }
    if (ids.color >= 0) {
      const std::array<std::uint16_t, 4> rgba = {LinearFromSrgb(v.color[0]),
                                                 LinearFromSrgb(v.color[1]),
                                                 LinearFromSrgb(v.color[2]),
                                                 65535};
      mesh->attribute(ids.color)->SetAttributeValue(index, rgba.data());
    }
  }
  for (std::size_t i = 0; i < model.faces.size(); ++i) {
    draco::Mesh::Face face;
    for (int k = 0; k < 3; ++k) {
      face[static_cast<std::size_t>(k)] = static_cast<std::uint32_t>(model.faces[i][k]);
    }
    mesh->SetFace(draco::FaceIndex(static_cast<std::uint32_t>(i)), face);
  }
  return ids;
}

}  // namespace

DracoMesh CompressMesh(const ExchangeModel& model,
                       const Eigen::Vector3d& origin,
                       int position_bits) {
  draco::Mesh mesh;
  const Attributes ids = FillMesh(model, origin, &mesh);
  draco::ExpertEncoder encoder(mesh);
  encoder.SetTrackEncodedProperties(true);
  encoder.SetEncodingMethod(draco::MESH_EDGEBREAKER_ENCODING);
  constexpr int kSpeed = 3;  // 0 smallest ... 10 fastest
  encoder.SetSpeedOptions(kSpeed, kSpeed);
  encoder.SetAttributeQuantization(ids.position, position_bits);
  if (ids.normal >= 0) encoder.SetAttributeQuantization(ids.normal, kNormalBits);
  draco::EncoderBuffer buffer;
  const draco::Status status = encoder.EncodeToBuffer(&buffer);
  if (!status.ok()) {
    throw Error(ErrorKind::kFailed,
                std::string("Draco cannot compress the mesh: ") + status.error_msg());
  }
  DracoMesh result;
  result.bytes.assign(buffer.data(), buffer.size());
  result.points = static_cast<std::int64_t>(encoder.num_encoded_points());
  result.faces = static_cast<std::int64_t>(encoder.num_encoded_faces());
  const auto unique_id = [&](int id) {
    return id < 0 ? -1 : static_cast<int>(mesh.attribute(id)->unique_id());
  };
  result.position_id = unique_id(ids.position);
  result.normal_id = unique_id(ids.normal);
  result.color_id = unique_id(ids.color);
  return result;
}

}  // namespace livemvs
