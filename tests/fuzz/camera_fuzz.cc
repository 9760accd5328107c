// Hostile bytes as a camera's calibration: OpenCV's YAML, or numbers in a text file. The first byte
// chooses. What is read is a camera that projects, and is read again as it is written.

#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <span>
#include <string>

#include "file_input.h"
#include "livemvs/core/error.h"
#include "livemvs/io/calibration.h"

namespace {

using namespace livemvs;

void Require(bool condition) {
  if (!condition) std::abort();
}

std::optional<Camera> Read(std::span<const std::uint8_t> bytes, bool yaml) {
  try {
    const FileInput file(bytes);
    return yaml ? ReadOpenCvYaml(file.path()) : ReadIntrinsicsText(file.path());
  } catch (const Error&) {
    return std::nullopt;
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::optional<Camera> camera = Read({data + 1, size - 1}, data[0] % 2 == 0);
  if (!camera) return 0;
  Camera sized = *camera;
  if (sized.width == 0) sized.width = sized.height = 640;
  sized.Check();
  const Projector projector(sized);
  for (const Eigen::Vector2d& pixel : {Eigen::Vector2d(0, 0), Eigen::Vector2d(320, 240)}) {
    const auto ray = projector.Unproject(pixel);
    if (ray) Require(ray->allFinite());
  }
  const std::filesystem::path path =
      std::filesystem::temp_directory_path() / ("camera_fuzz_" + std::to_string(::getpid()));
  WriteOpenCvYaml(path, sized);
  const Camera again = ReadOpenCvYaml(path);
  std::filesystem::remove(path);
  Require(again.fx == sized.fx && again.cy == sized.cy && again.width == sized.width);
  Require(again.distortion == sized.distortion);
  return 0;
}
