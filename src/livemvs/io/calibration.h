#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "livemvs/core/camera.h"

namespace livemvs {

/// Reads a camera from OpenCV YAML: camera_matrix, distortion_coefficients (4, 5 or 8; or 4 of the
/// fisheye model where distortion_model or camera_model says "fisheye" or "equidistant"), and
/// image_width, image_height, without which the size stays 0 x 0.
/// @throws Error (kBadInput) naming file, place and remedy.
Camera ReadOpenCvYaml(const std::filesystem::path& file);

/// Writes a camera so that ReadOpenCvYaml() and OpenCV read it; a pinhole camera has distortion
/// coefficients 0. The file appears whole or not at all.
/// @param notes  Comments in front, a line each.
/// @throws Error (kOutOfResource) where it cannot be written.
void WriteOpenCvYaml(const std::filesystem::path& file,
                     const Camera& camera,
                     const std::vector<std::string>& notes = {});

/// Reads "fx fy cx cy [width height]" (integer pixel centres) from the first line of a text file.
Camera ReadIntrinsicsText(const std::filesystem::path& file);

/// A camera from "fx,fy,cx,cy[,k1,k2,p1,p2[,k3[,k4,k5,k6]]]", integer pixel centres; size 0 x 0.
/// @throws std::invalid_argument naming what is wrong.
Camera ParseCameraList(const std::string& list);

/// A camera as --camera states it: a file (YAML or text), or the list.
Camera ReadCamera(const std::string& camera);

/// The calibration file in a folder, by its usual names, if any.
std::optional<std::filesystem::path> FindCalibration(const std::filesystem::path& folder);

}  // namespace livemvs
