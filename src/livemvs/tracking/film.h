#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "livemvs/core/camera.h"
#include "livemvs/core/frame.h"
#include "livemvs/synth/camera_path.h"
#include "livemvs/tracking/board.h"

namespace livemvs {

/// Conditions under which a board is filmed. For tests and measurements of the tracker: a plane, a
/// few discs above it and a lens are all there is, so that ten thousand frames take minutes; see
/// synth/ for real scenes.
struct FilmOptions {
  Board board;
  Camera camera;
  PathOptions path;        ///< The hand-held camera's; frames and unrest included.
  double noise_sigma = 0;  ///< Of the sensor [grey levels].
  double shutter = 0;      ///< Part of a frame's time that the shutter is open.
  double readout = 0;      ///< Part of a frame's time between first and last row (rolling shutter).
  double hidden = 0;       ///< Part of the corners that discs above the sheet hide, about.
  bool decoys = false;     ///< The cloth around the board and the discs are chequered like it.
  int leave_every = 0;     ///< The camera turns away for a while every so many frames; 0: never.
  int samples = 8;         ///< Per pixel.
  std::uint64_t seed = 1;
};

/// A picture and the truth about it.
struct FilmFrame {
  Picture picture;
  Rigid3d cam_from_world;   ///< In the middle of the exposure of the middle row.
  int visible_corners = 0;  ///< In the picture and not hidden.
  int corners_in_view = 0;  ///< In the picture, hidden or not.
};

/// Films a board. Frames are independent of each other.
class Film {
 public:
  explicit Film(const FilmOptions& options);

  FilmFrame Frame(int index) const;

  /// cam_from_world at a time in frames.
  Rigid3d PoseAt(double frame) const;

 private:
  struct Disc {
    Eigen::Vector3d center;
    double radius;
  };
  struct Eye;
  void PlaceDiscs();
  Eigen::Vector2d SubPixel(int sample) const;
  float LightAlong(const Eye& eye, const Eigen::Vector3d& ray_in_cam) const;
  bool Hidden(const Eigen::Vector3d& eye, const Eigen::Vector3d& point) const;
  void CountCorners(FilmFrame* frame) const;

  FilmOptions options_;
  Image<std::uint8_t> print_;
  double print_per_metre_ = 0;
  std::vector<Disc> discs_;
  std::vector<Eigen::Vector3f> rays_;  // of each pixel's samples; z = 0: none
};

/// Pictures that calibrate a square camera: somebody films the board from all sides and held in all
/// ways, its corners in all parts of the picture. Forty of them, each by itself.
std::vector<Image<std::uint8_t>> FilmFromAllSides(const Camera& camera);

}  // namespace livemvs
