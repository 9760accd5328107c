// What is written, as other people's readers see it: tinygltf, assimp, and Draco's decoder.
#include <draco/compression/decode.h>
#include <gtest/gtest.h>
#include <tiny_gltf.h>

#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <assimp/Importer.hpp>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "livemvs/core/error.h"
#include "livemvs/exchange/glb.h"
#include "livemvs/exchange/las.h"
#include "livemvs/exchange/obj.h"
#include "temporary.h"

namespace livemvs {
namespace {

namespace fs = std::filesystem;
using testing_support::Temporary;

// A tetrahedron whose vertices differ in everything.
ExchangeModel Tetrahedron(const Eigen::Vector3f& at = Eigen::Vector3f::Zero()) {
  TriangleMesh mesh;
  mesh.vertices = {at,
                   at + Eigen::Vector3f(1, 0, 0),
                   at + Eigen::Vector3f(0, 2, 0),
                   at + Eigen::Vector3f(0, 0, 3)};
  mesh.faces = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  mesh.colors = {{255, 0, 0}, {0, 128, 0}, {0, 0, 10}, {200, 100, 50}};
  return MakeExchangeModel(mesh);
}

ExchangeModel Cloud() {
  ExchangeModel model = Tetrahedron();
  model.faces.clear();
  return model;
}

tinygltf::Model Load(const fs::path& path) {
  tinygltf::Model model;
  std::string error, warning;
  EXPECT_TRUE(tinygltf::TinyGLTF().LoadBinaryFromFile(&model, &error, &warning, path.string()))
      << error;
  EXPECT_EQ(error + warning, "");
  return model;
}

template <typename T>
const T* Data(const tinygltf::Model& model, int accessor) {
  const auto& a = model.accessors.at(static_cast<std::size_t>(accessor));
  const auto& view = model.bufferViews.at(static_cast<std::size_t>(a.bufferView));
  return reinterpret_cast<const T*>(model.buffers.at(0).data.data() + view.byteOffset);
}

// The inverse of LinearFromSrgb(), by the formula of IEC 61966-2-1 the other way round.
double SrgbFromLinear(double linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

TEST(GlbReaders, TinyGltfReadsTheMesh) {
  const fs::path path = Temporary("tetrahedron.glb");
  const ExchangeModel model = Tetrahedron();
  WriteGlb(path, model);
  const tinygltf::Model read = Load(path);
  const tinygltf::Primitive& primitive = read.meshes.at(0).primitives.at(0);
  EXPECT_EQ(primitive.mode, TINYGLTF_MODE_TRIANGLES);
  const int positions = primitive.attributes.at("POSITION");
  EXPECT_EQ(read.accessors[static_cast<std::size_t>(positions)].maxValues,
            (std::vector<double>{1, 2, 3}));
  const float* p = Data<float>(read, positions);
  const float* n = Data<float>(read, primitive.attributes.at("NORMAL"));
  const auto* c = Data<std::uint16_t>(read, primitive.attributes.at("COLOR_0"));
  for (int i = 0; i < 4; ++i) {
    const Point& v = model.vertices[static_cast<std::size_t>(i)];
    for (int k = 0; k < 3; ++k) {
      EXPECT_EQ(p[3 * i + k], v.position[k]);
      EXPECT_NEAR(n[3 * i + k], v.normal[k], 1e-6);
      EXPECT_EQ(std::lround(255 * SrgbFromLinear(c[4 * i + k] / 65535.0)),
                v.color[static_cast<std::size_t>(k)]);
    }
  }
  const auto* indices = Data<std::uint32_t>(read, primitive.indices);
  EXPECT_EQ(indices[1], 2u);
  EXPECT_EQ(indices[11], 3u);
}

TEST(GlbReaders, TinyGltfReadsTheCloudAsPoints) {
  const fs::path path = Temporary("cloud.glb");
  WriteGlb(path, Cloud());
  const tinygltf::Primitive primitive = Load(path).meshes.at(0).primitives.at(0);
  EXPECT_EQ(primitive.mode, TINYGLTF_MODE_POINTS);
  EXPECT_EQ(primitive.indices, -1);
}

TEST(GlbReaders, AssimpPutsTheWorldsUpAxisOnY) {
  const std::array<std::pair<UpAxis, Eigen::Vector3f>, 3> cases = {
      {{UpAxis::kZ, {0, 0, 3}}, {UpAxis::kY, {0, 2, 0}}, {UpAxis::kMinusY, {0, -5, 0}}}};
  for (const auto& [up, top] : cases) {
    ExchangeModel model = Tetrahedron();
    model.vertices[3].position = top;
    const fs::path path = Temporary("up.glb");
    WriteGlb(path, model, {.up = up});
    Assimp::Importer importer;
    const aiScene* scene = importer.ReadFile(path.string(), aiProcess_PreTransformVertices);
    ASSERT_NE(scene, nullptr) << importer.GetErrorString();
    ASSERT_EQ(scene->mNumMeshes, 1u);
    EXPECT_NEAR(scene->mMeshes[0]->mVertices[3].y, top.norm(), 1e-6);
    EXPECT_NEAR(scene->mMeshes[0]->mVertices[3].x, 0, 1e-6);
    EXPECT_EQ(scene->mMeshes[0]->mNumFaces, 4u);
  }
}

TEST(GlbReaders, FarFromTheOriginTheNodeCarriesThePlace) {
  const fs::path path = Temporary("far.glb");
  WriteGlb(path, Tetrahedron({4096, -8192, 64}));
  const tinygltf::Model read = Load(path);
  const tinygltf::Node& node = read.nodes.at(0);
  // The middle of the box, its z on y and its y on -z.
  ASSERT_EQ(node.translation.size(), 3u);
  EXPECT_NEAR(node.translation[0], 4096.5, 1e-9);
  EXPECT_NEAR(node.translation[1], 65.5, 1e-9);
  EXPECT_NEAR(node.translation[2], 8191, 1e-9);
  const float* p = Data<float>(read, read.meshes.at(0).primitives.at(0).attributes.at("POSITION"));
  EXPECT_FLOAT_EQ(p[0], -0.5f);
}

TEST(GlbReaders, DracosDecoderGivesTheMeshBack) {
  ExchangeModel model = Tetrahedron();
  const fs::path path = Temporary("draco.glb");
  WriteGlb(path, model, {.draco = true});
  // Debian's tinygltf is built without Draco and refuses such files: take the container apart here.
  std::ifstream file(path, std::ios::binary);
  const std::string bytes(std::istreambuf_iterator<char>(file), {});
  std::uint32_t json_size = 0;
  std::memcpy(&json_size, bytes.data() + 12, 4);
  const auto read = nlohmann::json::parse(bytes.substr(20, json_size));
  const auto& primitive = read.at("meshes")[0].at("primitives")[0];
  const auto& extension = primitive.at("extensions").at("KHR_draco_mesh_compression");
  const auto& view = read.at("bufferViews")[extension.at("bufferView").get<std::size_t>()];
  draco::DecoderBuffer buffer;
  buffer.Init(bytes.data() + 28 + json_size + view.at("byteOffset").get<std::size_t>(),
              view.at("byteLength").get<std::size_t>());
  auto decoded = draco::Decoder().DecodeMeshFromBuffer(&buffer);
  ASSERT_TRUE(decoded.ok());
  const draco::Mesh& mesh = *decoded.value();
  const auto count = [&](const nlohmann::json& i) {
    return read.at("accessors")[i.get<std::size_t>()].at("count").get<std::size_t>();
  };
  EXPECT_EQ(count(primitive.at("indices")), 3 * mesh.num_faces());
  EXPECT_EQ(count(primitive.at("attributes").at("POSITION")), mesh.num_points());
  const draco::PointAttribute* positions =
      mesh.GetAttributeByUniqueId(extension.at("attributes").at("POSITION").get<std::uint32_t>());
  ASSERT_NE(positions, nullptr);
  constexpr double kStep = 3.0 / 65535;  // 16 bits over the longest side
  double worst = 0;
  for (std::uint32_t i = 0; i < mesh.num_points(); ++i) {
    Eigen::Vector3f p;
    positions->GetMappedValue(draco::PointIndex(i), p.data());
    double nearest = 1e9;
    for (const Point& v : model.vertices) {
      nearest = std::min<double>(nearest, (v.position - p).norm());
    }
    worst = std::max(worst, nearest);
  }
  EXPECT_LE(worst, kStep);
  EXPECT_EQ(mesh.num_faces(), 4u);
}

TEST(ObjReaders, AssimpReadsVerticesNormalsAndColours) {
  const fs::path path = Temporary("tetrahedron.obj");
  const ExchangeModel model = Tetrahedron();
  WriteObj(path, model);
  Assimp::Importer importer;
  const aiScene* scene = importer.ReadFile(path.string(), 0);
  ASSERT_NE(scene, nullptr) << importer.GetErrorString();
  ASSERT_EQ(scene->mNumMeshes, 1u);
  const aiMesh& mesh = *scene->mMeshes[0];
  EXPECT_EQ(mesh.mNumFaces, 4u);
  ASSERT_TRUE(mesh.HasNormals() && mesh.HasVertexColors(0));
  for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
    ASSERT_EQ(mesh.mFaces[f].mNumIndices, 3u);
    for (int k = 0; k < 3; ++k) {
      const unsigned i = mesh.mFaces[f].mIndices[k];
      const Point& v = model.vertices[static_cast<std::size_t>(model.faces[f][k])];
      const aiVector3D& p = mesh.mVertices[i];
      EXPECT_EQ(Eigen::Vector3f(p.x, p.y, p.z), v.position);
      const aiVector3D& n = mesh.mNormals[i];
      EXPECT_LT((Eigen::Vector3f(n.x, n.y, n.z) - v.normal).norm(), 1e-5);
      EXPECT_EQ(std::lround(255 * mesh.mColors[0][i].g), v.color[1]);
    }
  }
  std::string name;
  aiString read;
  scene->mMaterials[mesh.mMaterialIndex]->Get(AI_MATKEY_NAME, read);
  EXPECT_STREQ(read.C_Str(), "surface");
}

// --- What cannot be written -------------------------------------------------------------------

TEST(Exchange, RefusesWhatAFormCannotHold) {
  EXPECT_THROW(WriteGlb(Temporary("x.glb"), {}), std::invalid_argument);
  EXPECT_THROW(WriteGlb(Temporary("x.glb"), Cloud(), {.draco = true}), std::invalid_argument);
  EXPECT_THROW(WriteObj(Temporary("x.obj"), Cloud()), std::invalid_argument);
  EXPECT_THROW(WriteLas(Temporary("x.las"), Tetrahedron()), std::invalid_argument);
  ExchangeModel bad = Tetrahedron();
  bad.vertices[2].position.y() = std::nanf("");
  EXPECT_THROW(WriteGlb(Temporary("x.glb"), bad), std::invalid_argument);
  bad = Tetrahedron();
  bad.faces[0][1] = 4;
  EXPECT_THROW(WriteGlb(Temporary("x.glb"), bad), std::invalid_argument);
  for (const char* name : {"x.glb", "x.obj", "x.mtl", "x.las"}) {
    EXPECT_FALSE(fs::exists(Temporary(name))) << name;
  }
  EXPECT_THROW(MakeExchangeModel(PlyContents{}, "empty.ply"), Error);
}

TEST(Exchange, AFullDiskIsAnErrorThatNamesTheFile) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "no /dev/full";
  for (const auto& write :
       {+[] { WriteGlb("/dev/full", Tetrahedron()); }, +[] { WriteLas("/dev/full", Cloud()); }}) {
    try {
      write();
      FAIL() << "no error";
    } catch (const Error& e) {
      EXPECT_EQ(e.kind(), ErrorKind::kOutOfResource);
      EXPECT_NE(std::string(e.what()).find("/dev/full"), std::string::npos);
      EXPECT_NE(std::string(e.what()).find("disk full"), std::string::npos);
    }
  }
}

TEST(Exchange, ThinningKeepsTheBestSeenEvenly) {
  ExchangeModel model;
  model.vertices.resize(100);
  for (int i = 0; i < 100; ++i) {
    model.vertices[static_cast<std::size_t>(i)].position.x() = static_cast<float>(i);
    model.vertices[static_cast<std::size_t>(i)].views = static_cast<std::uint16_t>(i % 2 * 5);
  }
  ThinCloud(10, 3, &model);
  ASSERT_EQ(model.vertices.size(), 10u);
  for (const Point& p : model.vertices) EXPECT_EQ(p.views, 5);
  EXPECT_EQ(model.vertices.front().position.x(), 1);
  EXPECT_GT(model.vertices.back().position.x(), 85);
}

}  // namespace
}  // namespace livemvs
