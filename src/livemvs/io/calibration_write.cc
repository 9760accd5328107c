#include <cstdio>
#include <string>

#include "livemvs/io/atomic_file.h"
#include "livemvs/io/calibration.h"

namespace livemvs {
namespace {

std::string Number(double value) {
  char text[40];
  std::snprintf(text, sizeof(text), "%.17g", value);
  return text;
}

std::string Matrix(const char* name, int rows, int cols, const std::string& data) {
  return std::string(name) + ": !!opencv-matrix\n   rows: " + std::to_string(rows) +
         "\n   cols: " + std::to_string(cols) + "\n   dt: d\n   data: [ " + data + " ]\n";
}

}  // namespace

void WriteOpenCvYaml(const std::filesystem::path& file,
                     const Camera& camera,
                     const std::vector<std::string>& notes) {
  const bool fisheye = camera.model == CameraModel::kKannalaBrandt;
  std::string yaml = "%YAML:1.0\n---\n";
  for (const std::string& note : notes) yaml += "# " + note + "\n";
  yaml += "image_width: " + std::to_string(camera.width) + "\n";
  yaml += "image_height: " + std::to_string(camera.height) + "\n";
  if (fisheye) yaml += "distortion_model: fisheye\n";
  yaml += Matrix("camera_matrix",
                 3,
                 3,
                 Number(camera.fx) + ", 0., " + Number(camera.cx) + ", 0., " + Number(camera.fy) +
                     ", " + Number(camera.cy) + ", 0., 0., 1.");
  // Few programs know the rational model: it is written only where it is used.
  const bool rational =
      camera.distortion[5] != 0 || camera.distortion[6] != 0 || camera.distortion[7] != 0;
  const int count = fisheye ? 4 : rational ? 8 : 5;
  std::string coefficients;
  for (int i = 0; i < count; ++i) {
    coefficients += (i > 0 ? ", " : "") + Number(camera.distortion[i]);
  }
  yaml += Matrix("distortion_coefficients", 1, count, coefficients);
  AtomicFile out(file);
  out.Write(yaml);
  out.Commit();
}

}  // namespace livemvs
