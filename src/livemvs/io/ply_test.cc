#include "livemvs/io/ply.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include <bit>
#include <cstring>
#include <limits>
#include <random>
#include <stdexcept>

#include "livemvs/io/media_test_util.h"

namespace livemvs {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::SizeIs;

class PlyTest : public MediaTest {
 protected:
  PlyContents Read(const std::string& bytes) {
    WriteBytes(folder_ / "a.ply", bytes);
    return ReadPly(folder_ / "a.ply");
  }
  std::string ErrorOf(const std::string& bytes) {
    const std::string message = BadInputMessage([&] { Read(bytes); });
    EXPECT_THAT(message, HasSubstr("a.ply"));
    return message;
  }

  static PointCloud MakeCloud(int count) {
    std::mt19937 random(1);
    std::normal_distribution<float> normal;
    PointCloud cloud(static_cast<std::size_t>(count));
    for (Point& point : cloud) {
      point.position = {normal(random), normal(random), 1e5f * normal(random)};
      point.normal = {0, 0.6f, -0.8f};
      point.color = {static_cast<std::uint8_t>(random()), 0, 255};
      point.sigma = normal(random);
      point.inlier_ratio = 0.75f;
      point.views = static_cast<std::uint16_t>(random());
    }
    return cloud;
  }

  static void ExpectSame(const PointCloud& a, const PointCloud& b) {
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
      ASSERT_EQ(a[i].position, b[i].position);
      ASSERT_EQ(a[i].normal, b[i].normal);
      ASSERT_EQ(a[i].color, b[i].color);
      ASSERT_EQ(a[i].sigma, b[i].sigma);
      ASSERT_EQ(a[i].inlier_ratio, b[i].inlier_ratio);
      ASSERT_EQ(a[i].views, b[i].views);
    }
  }

  static std::string Header(const std::string& format, const std::string& rest) {
    return "ply\nformat " + format + " 1.0\n" + rest + "end_header\n";
  }
  static std::string Vertices(const std::string& count) {
    return "element vertex " + count + "\nproperty float x\nproperty float y\nproperty float z\n";
  }

  template <typename T>
  static std::string Bytes(T value, std::endian order) {
    std::string bytes(sizeof(T), '\0');
    std::memcpy(bytes.data(), &value, sizeof(T));
    if (order != std::endian::native) std::ranges::reverse(bytes);
    return bytes;
  }

  static constexpr const char* kLittle = "binary_little_endian";
};

TEST_F(PlyTest, CloudComesBackBitForBit) {
  const PointCloud cloud = MakeCloud(10'000);
  WritePly(folder_ / "a.ply", cloud, "towards the\ncamera");
  const PlyContents contents = ReadPly(folder_ / "a.ply");
  ExpectSame(contents.cloud, cloud);
  EXPECT_TRUE(contents.has_normals);
  EXPECT_TRUE(contents.has_colors);
  EXPECT_TRUE(contents.faces.empty());
  EXPECT_THAT(contents.comments, ::testing::Contains("normals: towards the camera"));
  WritePly(folder_ / "empty.ply", PointCloud{}, "none");
  EXPECT_TRUE(ReadPly(folder_ / "empty.ply").cloud.empty());
}

TEST_F(PlyTest, TheFileIsWhatTheFormatSays) {
  // An independent reading of the first row: 4 + 4 + 4, 12, 3, 4, 4, 2 bytes.
  PointCloud cloud = MakeCloud(1);
  cloud[0].position = {1, -2, 0.5f};
  cloud[0].views = 0x1234;
  WritePly(folder_ / "a.ply", cloud, "x");
  const std::string bytes = ReadBytes(folder_ / "a.ply");
  const std::size_t body = bytes.find("end_header\n") + 11;
  ASSERT_EQ(bytes.size() - body, 37u);
  EXPECT_EQ(bytes.substr(body, 12), std::string("\0\0\x80\x3f\0\0\0\xc0\0\0\0\x3f", 12));
  EXPECT_EQ(bytes.substr(body + 35), "\x34\x12");
}

TEST_F(PlyTest, FramesComeBackWhereTheyAreKnown) {
  PointCloud cloud = MakeCloud(3);
  cloud[0].frame = 0;
  cloud[2].frame = 2'000'000'000;
  WritePly(folder_ / "a.ply", cloud, "x");
  const PlyContents contents = ReadPly(folder_ / "a.ply");
  ExpectSame(contents.cloud, cloud);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(contents.cloud[i].frame, cloud[i].frame);
  EXPECT_EQ(cloud[1].frame, -1);
  const PlyContents odd = Read(Header("ascii", Vertices("4") + "property double frame\n") +
                               "0 0 0 -7\n1 0 0 nan\n2 0 0 1e300\n3 0 0 5\n");
  EXPECT_EQ(odd.cloud[0].frame, -1);
  EXPECT_EQ(odd.cloud[1].frame, -1);
  EXPECT_EQ(odd.cloud[2].frame, -1);
  EXPECT_EQ(odd.cloud[3].frame, 5);
}

TEST_F(PlyTest, MeshComesBack) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh.faces = {{0, 2, 1}, {0, 1, 3}, {3, 1, 2}};
  mesh.colors = {{1, 2, 3}, {4, 5, 6}, {7, 8, 9}, {10, 11, 12}};
  WritePly(folder_ / "a.ply", mesh);
  const TriangleMesh back = ReadMeshPly(folder_ / "a.ply");
  EXPECT_EQ(back.vertices, mesh.vertices);
  EXPECT_EQ(back.faces, mesh.faces);
  EXPECT_EQ(back.colors, mesh.colors);
  mesh.faces[0][1] = 4;
  EXPECT_THROW(WritePly(folder_ / "a.ply", mesh), std::invalid_argument);
  mesh.colors.pop_back();
  mesh.faces.clear();
  EXPECT_THROW(WritePly(folder_ / "a.ply", mesh), std::invalid_argument);
  WritePly(folder_ / "c.ply", MakeCloud(3), "x");
  EXPECT_THAT(BadInputMessage([&] { ReadMeshPly(folder_ / "c.ply"); }), HasSubstr("no faces"));
}

TEST_F(PlyTest, ReadsAsciiInAnyOrderAndType) {
  const PlyContents contents = Read(
      "ply\r\nformat ascii 1.0\r\ncomment hello world\r\nobj_info x\r\n"
      "element vertex 3\r\nproperty uchar green\r\nproperty double z\r\nproperty int x\r\n"
      "property float confidence\r\nproperty float y\r\nproperty uchar red\r\n"
      "property uchar blue\r\nelement edge 1\r\nproperty list uchar int ends\r\n"
      "element face 2\r\nproperty float quality\r\nproperty list uchar int vertex_index\r\n"
      "end_header\r\n"
      "10 0.5 1 9 +2e0 30 20\r\n  11 1 2 9 3 31 21\r\n\r\n12 2 3 9\n4 32 22\r\n"
      "2 0 1\r\n0.5 3 0 1 2\r\n0.5 4 0 1 2 0");
  EXPECT_THAT(contents.comments, ElementsAre("hello world"));
  ASSERT_THAT(contents.cloud, SizeIs(3));
  EXPECT_EQ(contents.cloud[0].position, Eigen::Vector3f(1, 2, 0.5f));
  EXPECT_EQ(contents.cloud[2].position, Eigen::Vector3f(3, 4, 2));
  EXPECT_EQ(contents.cloud[1].color, (Rgb{31, 11, 21}));
  EXPECT_FALSE(contents.has_normals);
  EXPECT_EQ(contents.cloud[0].sigma, 0);
  EXPECT_THAT(
      contents.faces,
      ElementsAre(Eigen::Vector3i(0, 1, 2), Eigen::Vector3i(0, 1, 2), Eigen::Vector3i(0, 2, 0)));
}

TEST_F(PlyTest, ReadsBothByteOrders) {
  for (const std::endian order : {std::endian::little, std::endian::big}) {
    const char* format = order == std::endian::little ? kLittle : "binary_big_endian";
    const PlyContents contents = Read(
        Header(format,
               "element vertex 2\nproperty double y\nproperty short x\nproperty ushort views\n"
               "property float z\nproperty float red\nproperty float green\nproperty float blue\n"
               "element face 1\nproperty list uint uint vertex_indices\n") +
        Bytes(1.5, order) + Bytes(std::int16_t{-3}, order) + Bytes(std::uint16_t{500}, order) +
        Bytes(2.0f, order) + Bytes(1.0f, order) + Bytes(0.2f, order) + Bytes(-1.0f, order) +
        Bytes(-7.0, order) + Bytes(std::int16_t{4}, order) + Bytes(std::uint16_t{1}, order) +
        std::string(16, '\0') + Bytes(3u, order) + Bytes(1u, order) + Bytes(0u, order) +
        Bytes(1u, order));
    ASSERT_THAT(contents.cloud, SizeIs(2));
    EXPECT_EQ(contents.cloud[0].position, Eigen::Vector3f(-3, 1.5f, 2));
    EXPECT_EQ(contents.cloud[0].views, 500);
    EXPECT_EQ(contents.cloud[0].color, (Rgb{255, 51, 0}));
    EXPECT_EQ(contents.cloud[1].position, Eigen::Vector3f(4, -7, 0));
    EXPECT_THAT(contents.faces, ElementsAre(Eigen::Vector3i(1, 0, 1)));
  }
}

TEST_F(PlyTest, LeavesOutRowsThatAreNotFinite) {
  const PlyContents contents =
      Read(Header("ascii",
                  Vertices("5") + "property float sigma\nelement face 2\n"
                                  "property list uchar int vertex_indices\n") +
           "0 0 0 1\nnan 0 0 1\n1 0 0 nan\n0 1e400 0 1\n0 1 0 1e-400\n3 0 2 4\n3 0 1 2\n");
  ASSERT_THAT(contents.cloud, SizeIs(3));
  EXPECT_EQ(contents.dropped_vertices, 2);
  EXPECT_EQ(contents.cloud[1].sigma, 0);
  EXPECT_THAT(contents.faces, ElementsAre(Eigen::Vector3i(0, 1, 2)));
  EXPECT_EQ(contents.dropped_faces, 1);
}

TEST_F(PlyTest, ReadsCompressedFiles) {
  const PointCloud cloud = MakeCloud(5000);
  WritePly(folder_ / "a.ply", cloud, "x");
  const std::string bytes = ReadBytes(folder_ / "a.ply");
  const gzFile file = gzopen((folder_ / "b.ply.gz").c_str(), "wb");
  ASSERT_EQ(gzwrite(file, bytes.data(), static_cast<unsigned>(bytes.size())),
            static_cast<int>(bytes.size()));
  gzclose(file);
  ExpectSame(ReadPly(folder_ / "b.ply.gz").cloud, cloud);

  PlyReadOptions options;
  options.max_unpacked_bytes = 100'000;
  BadInputMessage([&] { ReadPly(folder_ / "b.ply.gz", options); });
  const std::string packed = ReadBytes(folder_ / "b.ply.gz");
  WriteBytes(folder_ / "c.ply.gz", packed.substr(0, packed.size() / 2));
  BadInputMessage([&] { ReadPly(folder_ / "c.ply.gz"); });
}

TEST_F(PlyTest, RefusesABombOfComments) {
  // Header lines that unpack to far more than is accepted.
  const gzFile file = gzopen((folder_ / "b.ply.gz").c_str(), "wb9");
  gzputs(file, "ply\nformat ascii 1.0\n");
  const std::string line = "comment " + std::string(4000, 'x') + "\n";
  for (int i = 0; i < 1000; ++i) gzputs(file, line.c_str());
  gzclose(file);
  PlyReadOptions options;
  options.max_unpacked_bytes = 1'000'000;
  EXPECT_THAT(BadInputMessage([&] { ReadPly(folder_ / "b.ply.gz", options); }),
              HasSubstr("unpacks to more"));
}

TEST_F(PlyTest, RefusesBrokenHeaders) {
  EXPECT_THAT(ErrorOf(""), HasSubstr("empty"));
  EXPECT_THAT(ErrorOf("hello, world"), HasSubstr("no PLY"));
  EXPECT_THAT(ErrorOf("pl"), HasSubstr("ends early"));
  EXPECT_THAT(ErrorOf("ply\nformat ascii 1.0\n" + Vertices("1")), HasSubstr("end_header"));
  EXPECT_THAT(ErrorOf("ply\n" + Vertices("0") + "end_header\n"), HasSubstr("no format"));
  EXPECT_THAT(ErrorOf("ply\nformat ascii 1.0\ncomment " + std::string(1 << 20, 'x')),
              HasSubstr("longer than 4096"));
  EXPECT_THAT(ErrorOf(Header("utf8", "")), HasSubstr("unknown PLY format"));
  EXPECT_THAT(ErrorOf(Header("ascii", "property float x\n")), HasSubstr("before the first"));
  EXPECT_THAT(ErrorOf(Header("ascii", Vertices("0") + "property quad q\n")), HasSubstr("quad"));
  EXPECT_THAT(ErrorOf(Header("ascii", Vertices("0") + "property float x\n")), HasSubstr("twice"));
  EXPECT_THAT(ErrorOf(Header("ascii", "")), HasSubstr("no vertices"));
  EXPECT_THAT(ErrorOf(Header("ascii", "element vertex 0\nproperty float x\n")), HasSubstr("lack"));
  EXPECT_THAT(ErrorOf(Header("ascii", Vertices("0") + "property list uchar int ids\n")),
              HasSubstr("is a list"));
  EXPECT_THAT(ErrorOf(Header("ascii", Vertices("0") + "property list float int ids\n")),
              HasSubstr("integer"));
}

TEST_F(PlyTest, RefusesCountsThatTheFileCannotHold) {
  for (const char* count : {"-1", "x", "", "1.5", "99999999999999999999999"}) {
    EXPECT_THAT(ErrorOf(Header(kLittle, Vertices(count))), HasSubstr("not a count")) << count;
  }
  for (const char* count : {"2", "1000000000", "9223372036854775807"}) {
    for (const char* format : {"ascii", kLittle}) {
      EXPECT_THAT(ErrorOf(Header(format, Vertices(count)) + "0 0 0"), HasSubstr("cut short"))
          << count;
    }
  }
  const std::string faces = "element face 4000000000\nproperty list uchar int vertex_indices\n";
  EXPECT_THAT(ErrorOf(Header("ascii", Vertices("1") + faces) + "0 0 0"), HasSubstr("'face' rows"));
  // An element without properties takes no bytes and must take no time.
  const std::string nothing = "element nothing 9223372036854775807\n";
  EXPECT_THAT(Read(Header("ascii", nothing + Vertices("1")) + "0 0 0").cloud, SizeIs(1));
}

TEST_F(PlyTest, RefusesBrokenBodies) {
  const std::string faces = "element face 1\nproperty list uchar int vertex_indices\n";
  const std::string head = Header("ascii", Vertices("2") + faces);
  EXPECT_THAT(ErrorOf(head + "0 0 0 1 1 1 3 0 1 2"), HasSubstr("vertex 2"));
  EXPECT_THAT(ErrorOf(head + "0 0 0 1 1 1 3 0 1 -1"), HasSubstr("impossible vertex"));
  EXPECT_THAT(ErrorOf(head + "0 0 0 1 1 1 3 0 1 0.5"), HasSubstr("impossible vertex"));
  EXPECT_THAT(ErrorOf(head + "0 0 0 1 1 1 -3 0 1 1"), HasSubstr("corners"));
  EXPECT_THAT(ErrorOf(head + "0 0 0 1 1 1 1e9 0 1 1"), HasSubstr("corners"));
  EXPECT_THAT(ErrorOf(head + "0 0 0 1 1 1 3 0 1"), HasSubstr("ends early"));
  EXPECT_THAT(ErrorOf(head + "0 0 zero 1 1 1 3 0 1 1"), HasSubstr("'zero' is not a number"));
  EXPECT_THAT(ErrorOf(head + std::string(5000, '1')), HasSubstr("too long"));
  const std::string binary = Header(kLittle,
                                    Vertices("1") +
                                        "element other 1\n"
                                        "property list uint double v\n");
  EXPECT_THAT(ErrorOf(binary + std::string(12, '\0') + "\xff\xff\xff\xff"),
              HasSubstr("ends early"));
}

TEST_F(PlyTest, SurvivesRandomDamage) {
  TriangleMesh mesh;
  mesh.vertices.resize(20, Eigen::Vector3f(1, 2, 3));
  mesh.faces.resize(30, Eigen::Vector3i(0, 7, 19));
  WritePly(folder_ / "mesh.ply", mesh);
  const std::string good = ReadBytes(folder_ / "mesh.ply");
  std::mt19937 random(5);
  for (int trial = 0; trial < 400; ++trial) {
    std::string bad = good;
    for (int flip = 0; flip < 3; ++flip) bad[random() % bad.size()] = static_cast<char>(random());
    if (trial % 2) bad.resize(random() % bad.size());
    try {
      const PlyContents contents = Read(bad);
      for (const Eigen::Vector3i& face : contents.faces) {
        ASSERT_GE(face.minCoeff(), 0);
        ASSERT_LT(face.maxCoeff(), static_cast<int>(contents.cloud.size()));
      }
    } catch (const Error& error) {
      ASSERT_EQ(error.kind(), ErrorKind::kBadInput);
    }
  }
}

}  // namespace
}  // namespace livemvs
