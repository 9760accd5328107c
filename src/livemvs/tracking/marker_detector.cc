#include "livemvs/tracking/marker_detector.h"

#include <map>
#include <opencv2/aruco.hpp>

#include "livemvs/tracking/downsample.h"
#include "livemvs/tracking/opencv_dictionary.h"

namespace livemvs {

struct MarkerDetector::Impl {
  cv::Ptr<cv::aruco::Dictionary> dictionary;
  cv::Ptr<cv::aruco::DetectorParameters> parameters = cv::aruco::DetectorParameters::create();
  std::map<int, int> index_of_id;
  int detect_width = 0;
};

MarkerDetector::MarkerDetector(const Board& board, int detect_width)
    : impl_(std::make_unique<Impl>()) {
  impl_->dictionary = OpenCvDictionary(board.dictionary);
  impl_->detect_width = detect_width;
  // Corners are refined afterwards, by FitCorner.
  impl_->parameters->cornerRefinementMethod = cv::aruco::CORNER_REFINE_NONE;
  impl_->parameters->adaptiveThreshWinSizeMin = 7;
  impl_->parameters->adaptiveThreshWinSizeMax = 23;
  impl_->parameters->adaptiveThreshWinSizeStep = 16;
  const std::vector<BoardMarker> markers = MarkersOf(board);
  for (std::size_t i = 0; i < markers.size(); ++i) {
    impl_->index_of_id[markers[i].id] = static_cast<int>(i);
  }
}

MarkerDetector::~MarkerDetector() = default;
MarkerDetector::MarkerDetector(MarkerDetector&&) noexcept = default;
MarkerDetector& MarkerDetector::operator=(MarkerDetector&&) noexcept = default;

std::vector<DetectedMarker> MarkerDetector::Detect(ImageView<std::uint8_t> image) {
  int factor = 1;
  while (factor < 8 && image.width / (2 * factor) >= impl_->detect_width) factor *= 2;
  Image<std::uint8_t> small;
  ImageView<std::uint8_t> view = image;
  if (factor > 1) {
    small = Downsample(image, factor);
    view = small.view();
  }
  // OpenCV reads the pixels only, but has no type that says so.
  const cv::Mat mat(view.height,
                    view.width,
                    CV_8UC1,
                    const_cast<std::uint8_t*>(view.data),
                    static_cast<std::size_t>(view.stride));
  std::vector<int> ids;
  std::vector<std::vector<cv::Point2f>> corners;
  cv::aruco::detectMarkers(mat, impl_->dictionary, corners, ids, impl_->parameters);
  std::map<int, int> times_seen;
  for (const int id : ids) ++times_seen[id];
  std::vector<DetectedMarker> found;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    const auto index = impl_->index_of_id.find(ids[i]);
    if (index == impl_->index_of_id.end() || times_seen[ids[i]] > 1) continue;
    DetectedMarker marker;
    marker.index = index->second;
    for (int k = 0; k < 4; ++k) {
      const Eigen::Vector2d p(corners[i][k].x, corners[i][k].y);
      marker.corners[k] = ((p.array() + 0.5) * factor - 0.5).matrix();
    }
    found.push_back(marker);
  }
  return found;
}

}  // namespace livemvs
