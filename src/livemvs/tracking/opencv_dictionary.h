#pragma once

#include <opencv2/aruco/dictionary.hpp>
#include <string>

namespace livemvs {

/// OpenCV's dictionary of that name. Of this folder alone: no other header speaks of OpenCV.
/// @throws std::invalid_argument where there is none of it.
cv::Ptr<cv::aruco::Dictionary> OpenCvDictionary(const std::string& name);

}  // namespace livemvs
