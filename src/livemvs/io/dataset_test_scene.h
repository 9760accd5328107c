#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "livemvs/core/camera.h"
#include "livemvs/core/log.h"
#include "livemvs/core/pose.h"
#include "livemvs/io/dataset.h"

namespace livemvs::testing_io {

/// Of pixels that go through a file with 17 digits [px].
inline constexpr double kTolerance = 1e-6;

/// A few cameras that look at a few points. The pixels are computed here, by the models' formulas
/// written out once more, and every format that is read back must lead to the same ones.
struct TestScene {
  Camera camera;
  std::vector<Rigid3d> cam_from_world;
  std::vector<Eigen::Vector3d> points;
  std::vector<std::vector<Eigen::Vector2d>> pixels;  ///< [view][point], integer pixel centres.

  std::size_t size() const { return cam_from_world.size(); }
};

inline constexpr int kSceneWidth = 96;
inline constexpr int kSceneHeight = 64;

/// @param camera  Intrinsics; its size is set here.
TestScene MakeTestScene(Camera camera, int views = 5);

/// Cameras with different focal lengths and a principal point off the centre.
Camera PinholeCamera();
Camera BrownConradyCamera();
Camera KannalaBrandtCamera();

/// Grey level of all pixels of a view's picture, by which pictures are told apart.
inline int GreyOfView(std::size_t view) { return 60 + 25 * static_cast<int>(view); }

/// A fresh, empty folder below the test's temporary folder.
std::filesystem::path FreshFolder(const std::string& name);

void WriteText(const std::filesystem::path& path, const std::string& text);

/// A PGM picture of one grey level.
void WriteGreyImage(const std::filesystem::path& path,
                    int grey,
                    int width = kSceneWidth,
                    int height = kSceneHeight);

/// Pictures of all the views as folder/<prefix><number>.pgm; the numbers start from 0.
void WriteSceneImages(const TestScene& scene,
                      const std::filesystem::path& folder,
                      const std::string& prefix = "v");

/// A number with all its digits.
std::string Exact(double value);
/// The numbers of a matrix by rows, separated by blanks.
std::string Rows(const Eigen::MatrixXd& matrix);
/// "qw qx qy qz" of a rotation (Hamilton), from its matrix by Shepperd's formulas.
Eigen::Vector4d QuaternionWxyz(const Eigen::Matrix3d& rotation);

/// (R | t).
Eigen::Matrix<double, 3, 4> Matrix34(const Rigid3d& pose);
/// world_from_cam with the camera's y and z axes turned round, as OpenGL has them.
Eigen::Matrix4d OpenGlPose(const Rigid3d& cam_from_world);
/// A calibration file with the first five distortion coefficients.
std::string OpenCvYaml(const Camera& camera);
/// "time tx ty tz qx qy qz qw" and a line end, world_from_cam.
std::string TumRow(double time, const Rigid3d& cam_from_world);

/// Expects that the data set has the scene's views in order, projects its points to its pixels, and
/// hands out the pictures that belong to the views.
/// @param grey_tolerance  For lossy pictures.
void ExpectScene(Dataset& dataset,
                 const TestScene& scene,
                 double tolerance_px,
                 int grey_tolerance = 0);

/// Opens a folder with default options.
std::unique_ptr<Dataset> Open(const std::filesystem::path& data);

/// The message with which opening fails, or "" where it does not.
std::string OpenError(const DatasetOptions& options);
std::string OpenError(const std::filesystem::path& data);

/// Collects the library's messages while it lives.
class LogCatcher {
 public:
  LogCatcher();
  ~LogCatcher();

  const std::vector<std::string>& warnings() const { return warnings_; }
  const std::vector<std::string>& infos() const { return infos_; }

 private:
  std::vector<std::string> warnings_, infos_;
};

/// A folder of the shared real recordings (environment variable LIVEMVS_DATA, or beside the
/// repository), or an empty path where it is absent.
std::filesystem::path RealData(const std::string& name);

}  // namespace livemvs::testing_io
