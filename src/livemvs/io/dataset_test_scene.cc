#include "livemvs/io/dataset_test_scene.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include "livemvs/core/error.h"

namespace livemvs::testing_io {
namespace {

namespace fs = std::filesystem;

// The camera at `centre` that looks at the origin, turned by `roll` about its axis.
Rigid3d LookAtOrigin(const Eigen::Vector3d& centre, double roll) {
  const Eigen::Vector3d z = -centre.normalized();
  const Eigen::Vector3d x = Eigen::Vector3d::UnitZ().cross(z).normalized();
  Eigen::Matrix3d world_from_cam;
  world_from_cam.col(0) = x;
  world_from_cam.col(1) = z.cross(x);
  world_from_cam.col(2) = z;
  world_from_cam = world_from_cam * Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitZ());
  return Rigid3d{world_from_cam, centre}.Inverse();
}

// [OpenCV, camera calibration] written out, without the library's functors.
Eigen::Vector2d ProjectByFormula(const Camera& c, const Eigen::Vector3d& p) {
  double x = p.x() / p.z(), y = p.y() / p.z();
  const auto& k = c.distortion;
  if (c.model == CameraModel::kBrownConrady) {
    const double r2 = x * x + y * y, r4 = r2 * r2, r6 = r4 * r2;
    const double radial =
        (1 + k[0] * r2 + k[1] * r4 + k[4] * r6) / (1 + k[5] * r2 + k[6] * r4 + k[7] * r6);
    const double xd = x * radial + 2 * k[2] * x * y + k[3] * (r2 + 2 * x * x);
    const double yd = y * radial + k[2] * (r2 + 2 * y * y) + 2 * k[3] * x * y;
    x = xd, y = yd;
  } else if (c.model == CameraModel::kKannalaBrandt) {
    const double r = std::hypot(x, y), t = std::atan(r);
    const double td = t + k[0] * std::pow(t, 3) + k[1] * std::pow(t, 5) + k[2] * std::pow(t, 7) +
                      k[3] * std::pow(t, 9);
    x *= td / r, y *= td / r;
  }
  return {c.fx * x + c.cx, c.fy * y + c.cy};
}

Camera BaseCamera() {
  Camera camera;
  camera.fx = 110.25;
  camera.fy = 108.75;
  camera.cx = 46.125;
  camera.cy = 33.375;
  return camera;
}

}  // namespace

TestScene MakeTestScene(Camera camera, int views) {
  TestScene scene;
  camera.width = kSceneWidth;
  camera.height = kSceneHeight;
  scene.camera = camera;
  for (int i = 0; i < 12; ++i) {
    scene.points.emplace_back(
        0.25 * std::sin(1.0 + 2.1 * i), 0.2 * std::cos(3.7 * i), 0.2 * std::sin(0.3 + 5.3 * i));
  }
  for (int v = 0; v < views; ++v) {
    const double angle = 0.3 + 0.1 * v;
    const Eigen::Vector3d centre(1.1 * std::cos(angle), 1.1 * std::sin(angle), 0.5 + 0.02 * v);
    scene.cam_from_world.push_back(LookAtOrigin(centre, 0.15 - 0.05 * v));
    std::vector<Eigen::Vector2d> pixels;
    for (const Eigen::Vector3d& point : scene.points) {
      pixels.push_back(ProjectByFormula(camera, scene.cam_from_world.back() * point));
    }
    scene.pixels.push_back(std::move(pixels));
  }
  return scene;
}

Camera PinholeCamera() { return BaseCamera(); }

Camera BrownConradyCamera() {
  Camera camera = BaseCamera();
  camera.model = CameraModel::kBrownConrady;
  camera.distortion = {-0.12, 0.03, 0.002, -0.003};
  return camera;
}

Camera KannalaBrandtCamera() {
  Camera camera = BaseCamera();
  camera.model = CameraModel::kKannalaBrandt;
  camera.distortion = {0.02, -0.01, 0.004, -0.002};
  return camera;
}

fs::path FreshFolder(const std::string& name) {
  const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
  std::string unique = std::string(test->test_suite_name()) + "_" + test->name() + "_" + name;
  for (char& c : unique) c = c == '/' ? '_' : c;
  const fs::path folder = fs::path(::testing::TempDir()) / "livemvs_io" / unique;
  fs::remove_all(folder);
  fs::create_directories(folder);
  return folder;
}

void WriteText(const fs::path& path, const std::string& text) {
  fs::create_directories(path.parent_path());
  std::ofstream stream(path, std::ios::binary);
  stream << text;
  ASSERT_TRUE(stream.good()) << path;
}

void WriteGreyImage(const fs::path& path, int grey, int width, int height) {
  const std::string head =
      "P5\n" + std::to_string(width) + " " + std::to_string(height) + "\n255\n";
  WriteText(path,
            head + std::string(static_cast<std::size_t>(width * height), static_cast<char>(grey)));
}

void WriteSceneImages(const TestScene& scene, const fs::path& folder, const std::string& prefix) {
  for (std::size_t v = 0; v < scene.size(); ++v) {
    WriteGreyImage(folder / (prefix + std::to_string(v) + ".pgm"), GreyOfView(v));
  }
}

std::string Exact(double value) {
  std::ostringstream s;
  s.precision(17);
  s << value;
  return s.str();
}

std::string Rows(const Eigen::MatrixXd& matrix) {
  std::string text;
  for (Eigen::Index r = 0; r < matrix.rows(); ++r) {
    for (Eigen::Index c = 0; c < matrix.cols(); ++c) {
      text += (text.empty() ? "" : " ") + Exact(matrix(r, c));
    }
  }
  return text;
}

Eigen::Vector4d QuaternionWxyz(const Eigen::Matrix3d& r) {
  // Four times the squares of the components; the largest gives the others exactly.
  const Eigen::Vector4d squares(1 + r(0, 0) + r(1, 1) + r(2, 2),
                                1 + r(0, 0) - r(1, 1) - r(2, 2),
                                1 - r(0, 0) + r(1, 1) - r(2, 2),
                                1 - r(0, 0) - r(1, 1) + r(2, 2));
  Eigen::Index largest;
  squares.maxCoeff(&largest);
  const double wx = r(2, 1) - r(1, 2), wy = r(0, 2) - r(2, 0), wz = r(1, 0) - r(0, 1);
  const double xy = r(0, 1) + r(1, 0), xz = r(0, 2) + r(2, 0), yz = r(1, 2) + r(2, 1);
  Eigen::Matrix4d products;
  products << squares[0], wx, wy, wz, wx, squares[1], xy, xz, wy, xy, squares[2], yz, wz, xz, yz,
      squares[3];
  return products.col(largest).normalized();
}

Eigen::Matrix<double, 3, 4> Matrix34(const Rigid3d& pose) {
  Eigen::Matrix<double, 3, 4> m;
  m << pose.rotation, pose.translation;
  return m;
}

// World_from_cam with the camera's y and z axes turned round, as OpenGL has them.
Eigen::Matrix4d OpenGlPose(const Rigid3d& cam_from_world) {
  Eigen::Matrix4d world_from_cam = Eigen::Matrix4d::Identity();
  world_from_cam.topRows<3>() = Matrix34(cam_from_world);
  world_from_cam = world_from_cam.inverse().eval();
  return world_from_cam * Eigen::Vector4d(1, -1, -1, 1).asDiagonal();
}

std::string OpenCvYaml(const Camera& c) {
  std::string text =
      "%YAML:1.0\n---\nimage_width: 96\nimage_height: 64\n"
      "camera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: [ " +
      Exact(c.fx) + ", 0., " + Exact(c.cx) + ",\n       0., " + Exact(c.fy) + ", " + Exact(c.cy) +
      ", 0., 0., 1. ]\n"
      "distortion_coefficients: !!opencv-matrix\n   rows: 5\n   cols: 1\n   dt: d\n"
      "   data: [ ";
  for (int i = 0; i < 5; ++i) {
    text += (i == 0 ? "" : ", ") + Exact(c.distortion[static_cast<std::size_t>(i)]);
  }
  return text + " ]\n";
}

std::string TumRow(double time, const Rigid3d& cam_from_world) {
  const Rigid3d world_from_cam = cam_from_world.Inverse();
  const Eigen::Vector4d q = QuaternionWxyz(world_from_cam.rotation);
  return Exact(time) + " " + Rows(world_from_cam.translation.transpose()) + " " +
         Rows(Eigen::RowVector4d(q[1], q[2], q[3], q[0])) + "\n";
}

void ExpectScene(Dataset& dataset,
                 const TestScene& scene,
                 double tolerance_px,
                 int grey_tolerance) {
  ASSERT_EQ(dataset.views().size(), scene.size()) << dataset.description();
  for (std::size_t v = 0; v < scene.size(); ++v) {
    const DatasetView& view = dataset.views()[v];
    SCOPED_TRACE("view " + view.name);
    EXPECT_EQ(view.camera.width, kSceneWidth);
    EXPECT_EQ(view.camera.height, kSceneHeight);
    const Projector projector(view.camera);
    for (std::size_t p = 0; p < scene.points.size(); ++p) {
      const auto pixel = projector.Project(view.cam_from_world * scene.points[p]);
      ASSERT_TRUE(pixel.has_value());
      EXPECT_LE((*pixel - scene.pixels[v][p]).norm(), tolerance_px) << "point " << p;
    }
    const std::optional<PosedFrame> frame = dataset.Next();
    ASSERT_TRUE(frame.has_value());
    EXPECT_EQ(frame->index, view.index);
    EXPECT_NEAR(frame->timestamp, view.timestamp, 1e-3);
    EXPECT_NEAR(
        frame->picture->grey(kSceneWidth / 2, kSceneHeight / 2), GreyOfView(v), grey_tolerance);
    EXPECT_EQ(frame->camera.cx, view.camera.cx);
    EXPECT_LE((frame->cam_from_world.translation - view.cam_from_world.translation).norm(), 1e-9);
  }
  EXPECT_FALSE(dataset.Next().has_value());
  EXPECT_EQ(dataset.statistics().decoded, static_cast<std::int64_t>(scene.size()));
}

std::unique_ptr<Dataset> Open(const fs::path& data) {
  DatasetOptions options;
  options.data = data;
  return OpenDataset(options);
}

std::string OpenError(const DatasetOptions& options) {
  try {
    OpenDataset(options);
  } catch (const Error& e) {
    EXPECT_EQ(e.kind(), ErrorKind::kBadInput);
    return e.what();
  }
  return "";
}

std::string OpenError(const fs::path& data) {
  DatasetOptions options;
  options.data = data;
  return OpenError(options);
}

LogCatcher::LogCatcher() {
  SetLogCallback([this](LogLevel level, const std::string& message) {
    (level == LogLevel::kWarning ? warnings_ : infos_).push_back(message);
  });
}

LogCatcher::~LogCatcher() { SetLogCallback({}); }

fs::path RealData(const std::string& name) {
  const char* variable = std::getenv("LIVEMVS_DATA");
  const fs::path base = variable != nullptr && *variable != '\0'
                            ? fs::path(variable)
                            : fs::path(LIVEMVS_SOURCE_DIR) / "../shared/data";
  return fs::is_directory(base / name) ? base / name : fs::path();
}

}  // namespace livemvs::testing_io
