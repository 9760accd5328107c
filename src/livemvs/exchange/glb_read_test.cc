// What GLB files give back, whole and damaged.
#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <random>

#include "livemvs/core/error.h"
#include "livemvs/exchange/glb.h"
#include "temporary.h"

namespace livemvs {
namespace {

namespace fs = std::filesystem;

using testing_support::Temporary;

std::string BytesOf(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

fs::path FileOf(const std::string& bytes) {
  const fs::path path = Temporary("damaged.glb");
  std::ofstream(path, std::ios::binary) << bytes;
  return path;
}

// A strip of triangles with every colour that there is.
ExchangeModel Strip(const Eigen::Vector3f& at = Eigen::Vector3f::Zero()) {
  TriangleMesh mesh;
  for (int i = 0; i < 256; ++i) {
    const auto x = static_cast<float>(i);
    mesh.vertices.push_back(at + Eigen::Vector3f(0.01F * x, i % 2 == 0 ? 0 : 0.01F, 1 / (1 + x)));
    const auto c = static_cast<std::uint8_t>(i);
    mesh.colors.push_back(
        {c, static_cast<std::uint8_t>(255 - i), static_cast<std::uint8_t>(c / 2)});
    if (i >= 2) mesh.faces.push_back({i - 2, i - 1, i});
  }
  return MakeExchangeModel(mesh);
}

void ExpectSame(const ExchangeModel& read, const ExchangeModel& written) {
  ASSERT_EQ(read.vertices.size(), written.vertices.size());
  EXPECT_EQ(read.faces, written.faces);
  EXPECT_EQ(read.has_colors, written.has_colors);
  EXPECT_EQ(read.has_normals, written.has_normals);
  for (std::size_t i = 0; i < read.vertices.size(); ++i) {
    EXPECT_EQ(read.vertices[i].position, written.vertices[i].position);
    EXPECT_LT((read.vertices[i].normal - UnitNormal(written.vertices[i])).norm(), 1e-6);
    EXPECT_EQ(read.vertices[i].color, written.vertices[i].color);
  }
}

TEST(ReadGlb, GivesBackWhatWasWrittenInTheWorldsCoordinates) {
  const fs::path path = Temporary("back.glb");
  for (const UpAxis up : {UpAxis::kZ, UpAxis::kY, UpAxis::kMinusY}) {
    for (const Eigen::Vector3f& at : {Eigen::Vector3f(0, 0, 0), Eigen::Vector3f(4096, -8192, 64)}) {
      const ExchangeModel model = Strip(at);
      WriteGlb(path, model, {.up = up});
      ExpectSame(ReadGlb(path), model);
    }
  }
  ExchangeModel cloud = Strip();
  cloud.faces.clear();
  cloud.has_colors = false;
  for (Point& p : cloud.vertices) p.color = {};
  WriteGlb(path, cloud);
  ExpectSame(ReadGlb(path), cloud);
}

// The message must name the file and hold the words.
void ExpectRefused(const fs::path& path, const std::string& words) {
  try {
    ReadGlb(path);
    FAIL() << "no error, but expected: " << words;
  } catch (const Error& e) {
    EXPECT_EQ(e.kind(), ErrorKind::kBadInput);
    EXPECT_NE(std::string(e.what()).find(path.string()), std::string::npos) << e.what();
    EXPECT_NE(std::string(e.what()).find(words), std::string::npos) << e.what();
  }
}

std::string Replaced(std::string bytes, const std::string& from, const std::string& to) {
  EXPECT_EQ(from.size(), to.size());
  const std::size_t at = bytes.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return bytes.replace(at, from.size(), to);
}

TEST(ReadGlb, SaysWhatIsWrongWithOthersFiles) {
  const fs::path path = Temporary("whole.glb");
  WriteGlb(path, Strip());
  const std::string bytes = BytesOf(path);
  ExpectRefused(Temporary("missing.glb"), "cannot be opened");
  ExpectRefused(testing::TempDir(), "is a directory");
  ExpectRefused(FileOf(""), "not a GLB");
  ExpectRefused(FileOf("ply\nformat ascii 1.0\n"), "not a GLB");
  ExpectRefused(FileOf(bytes.substr(0, bytes.size() - 1)), "cut short");
  ExpectRefused(FileOf(Replaced(bytes, "\"livemvs\"", "\"blender\"")), "another program");
  ExpectRefused(FileOf(Replaced(bytes, "\"VEC3\"", "\"VEC2\"")), "kind");
  ExpectRefused(FileOf(Replaced(bytes, "\"count\":256", "\"count\":999")), "than it holds");
  ExpectRefused(FileOf(Replaced(bytes, "\"POSITION\"", "\"PLACES__\"")), "description is damaged");
  ExpectRefused(FileOf(Replaced(bytes, "{", "[")), "description is damaged");
  WriteGlb(path, Strip(), {.draco = true});
  ExpectRefused(path, "Draco");
}

TEST(ReadGlb, RefusesWildNumbers) {
  const fs::path path = Temporary("wild.glb");
  const ExchangeModel model = Strip();
  WriteGlb(path, model);
  std::string bytes = BytesOf(path);
  const std::uint32_t vertex = 256;  // one more than there are, in the last face
  std::memcpy(bytes.data() + bytes.size() - 4, &vertex, 4);
  ExpectRefused(FileOf(bytes), "vertex that does not exist");
  bytes = BytesOf(path);
  std::uint32_t json_size = 0;
  std::memcpy(&json_size, bytes.data() + 12, 4);
  const float infinite = std::numeric_limits<float>::infinity();
  std::memcpy(bytes.data() + 28 + json_size, &infinite, 4);
  ExpectRefused(FileOf(bytes), "not finite");
}

// Any byte may be any other: an error or a model, never more than that.
TEST(ReadGlb, SurvivesDamage) {
  const fs::path path = Temporary("to_damage.glb");
  WriteGlb(path, Strip());
  const std::string bytes = BytesOf(path);
  std::mt19937 random(3);
  int refused = 0;
  for (int round = 0; round < 500; ++round) {
    std::string damaged = bytes;
    for (int i = 0; i < 3; ++i) damaged[random() % 1200] = static_cast<char>(random());
    try {
      ReadGlb(FileOf(damaged)).Check();
    } catch (const Error&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 250);
}

}  // namespace
}  // namespace livemvs
