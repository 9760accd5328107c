#include "livemvs/tracking/dictionary.h"

#include <opencv2/aruco.hpp>
#include <stdexcept>

#include "livemvs/tracking/opencv_dictionary.h"

namespace livemvs {
namespace {

struct Known {
  const char* name;
  int opencv;
  int codes;
};

constexpr Known kKnown[] = {{"DICT_4X4_50", cv::aruco::DICT_4X4_50, 50},
                            {"DICT_4X4_100", cv::aruco::DICT_4X4_100, 100},
                            {"DICT_4X4_250", cv::aruco::DICT_4X4_250, 250},
                            {"DICT_4X4_1000", cv::aruco::DICT_4X4_1000, 1000},
                            {"DICT_5X5_50", cv::aruco::DICT_5X5_50, 50},
                            {"DICT_5X5_100", cv::aruco::DICT_5X5_100, 100},
                            {"DICT_5X5_250", cv::aruco::DICT_5X5_250, 250},
                            {"DICT_5X5_1000", cv::aruco::DICT_5X5_1000, 1000},
                            {"DICT_6X6_50", cv::aruco::DICT_6X6_50, 50},
                            {"DICT_6X6_100", cv::aruco::DICT_6X6_100, 100},
                            {"DICT_6X6_250", cv::aruco::DICT_6X6_250, 250},
                            {"DICT_6X6_1000", cv::aruco::DICT_6X6_1000, 1000},
                            {"DICT_APRILTAG_36h11", cv::aruco::DICT_APRILTAG_36h11, 587}};

const Known* Find(const std::string& name) {
  for (const Known& known : kKnown) {
    if (name == known.name) return &known;
  }
  return nullptr;
}

}  // namespace

int DictionarySize(const std::string& name) {
  const Known* known = Find(name);
  return known != nullptr ? known->codes : 0;
}

const char* KnownDictionaries() {
  return "must be DICT_4X4_N, DICT_5X5_N or DICT_6X6_N with N 50, 100, 250 or 1000, or "
         "DICT_APRILTAG_36h11";
}

cv::Ptr<cv::aruco::Dictionary> OpenCvDictionary(const std::string& name) {
  const Known* known = Find(name);
  if (known == nullptr) {
    throw std::invalid_argument("dictionary '" + name + "': " + KnownDictionaries());
  }
  return cv::aruco::getPredefinedDictionary(known->opencv);
}

MarkerBits BitsOf(const std::string& dictionary, int id) {
  const cv::Ptr<cv::aruco::Dictionary> codes = OpenCvDictionary(dictionary);
  if (id < 0 || id >= codes->bytesList.rows) {
    throw std::invalid_argument(dictionary + " has no code " + std::to_string(id));
  }
  const cv::Mat bits =
      cv::aruco::Dictionary::getBitsFromByteList(codes->bytesList.row(id), codes->markerSize);
  MarkerBits out;
  out.side = codes->markerSize;
  for (int y = 0; y < out.side; ++y) {
    for (int x = 0; x < out.side; ++x) out.white.push_back(bits.at<std::uint8_t>(y, x) != 0);
  }
  return out;
}

}  // namespace livemvs
