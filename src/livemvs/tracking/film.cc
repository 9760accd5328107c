#include "livemvs/tracking/film.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "livemvs/synth/noise.h"
#include "livemvs/synth/random.h"
#include "livemvs/synth/texture.h"
#include "livemvs/tracking/board_sheet.h"

namespace livemvs {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kPrintPixels = 96;                              // of the drawn board, along a square
constexpr float kInk = 0.02f, kPaper = 0.8f, kCloth = 0.25f;  // reflectances
constexpr double kAwayDegrees = 70;                           // how far the camera turns away
constexpr double kAwayFrames = 24;                            // and for how long
constexpr double kWhite = 0.012;                              // paper around the board [m]

// Grey levels of linear light, tabulated.
std::uint8_t Level(float light, float noise) {
  static const std::vector<float> table = [] {
    std::vector<float> levels;
    for (int i = 0; i <= 1024; ++i)
      levels.push_back(synth::ToSrgbLevel(static_cast<float>(i) / 1024));
    return levels;
  }();
  const float level = table[static_cast<std::size_t>(std::clamp(light, 0.f, 1.f) * 1024)];
  return static_cast<std::uint8_t>(std::clamp(level + noise + 0.5f, 0.f, 255.f));
}

// Nearly normal, variance 1: the sum of four of sixteen bits.
float Normal(std::uint64_t word) {
  float sum = 0;
  for (int i = 0; i < 4; ++i) sum += static_cast<float>(word >> (16 * i) & 0xFFFF) / 65536.f;
  return (sum - 2) * 1.7320508f;
}

bool Chequer(double x, double y, double side) {
  return ((static_cast<int>(std::floor(x / side)) + static_cast<int>(std::floor(y / side))) & 1) !=
         0;
}

}  // namespace

struct Film::Eye {
  Vector3d center;
  Eigen::Matrix3d world_from_cam;
};

Film::Film(const FilmOptions& options)
    : options_(options), print_(DrawBoard(options.board, kPrintPixels)) {
  print_per_metre_ = kPrintPixels / options.board.square;
  PlaceDiscs();
  const Projector projector(options.camera);
  const Camera& c = options.camera;
  rays_.reserve(static_cast<std::size_t>(c.width) * c.height * options.samples);
  for (int y = 0; y < c.height; ++y) {
    for (int x = 0; x < c.width; ++x) {
      for (int k = 0; k < options.samples; ++k) {
        const auto ray = projector.Unproject(Vector2d(x, y) + SubPixel(k));
        rays_.push_back(ray ? Eigen::Vector3f(ray->cast<float>()) : Eigen::Vector3f::Zero());
      }
    }
  }
}

// Points that are spread evenly over the pixel (the multiples of two irrational numbers), and whose
// mean is its centre.
Vector2d Film::SubPixel(int sample) const {
  const auto point = [](int k) {
    return Vector2d(std::fmod(0.7548776662466927 * k, 1.0), std::fmod(0.5698402909980532 * k, 1.0));
  };
  Vector2d mean = Vector2d::Zero();
  for (int k = 0; k < options_.samples; ++k) mean += point(k) / options_.samples;
  return point(sample) - mean;
}

void Film::PlaceDiscs() {
  synth::Random random(options_.seed * 77 + 5);
  const double x = 0.42 * options_.board.width(), y = 0.42 * options_.board.height();
  const std::vector<BoardCorner> corners = CornersOf(options_.board);
  const Vector3d above(0, -0.3, 0.45);
  for (int tries = 0; tries < 200 && options_.hidden > 0; ++tries) {
    int hidden = 0;
    for (const BoardCorner& c : corners) hidden += Hidden(above, c.point) ? 1 : 0;
    if (hidden >= options_.hidden * static_cast<double>(corners.size())) break;
    discs_.push_back({{random.Uniform(-x, x), random.Uniform(-y, y), random.Uniform(0.01, 0.06)},
                      random.Uniform(0.02, 0.045)});
  }
}

bool Film::Hidden(const Vector3d& eye, const Vector3d& point) const {
  for (const Disc& disc : discs_) {
    const double part = (eye.z() - disc.center.z()) / (eye.z() - point.z());
    const Vector3d at = eye + part * (point - eye);
    if ((at - disc.center).squaredNorm() < disc.radius * disc.radius) return true;
  }
  return false;
}

Rigid3d Film::PoseAt(double frame) const {
  const Rigid3d pose = livemvs::PoseAt(options_.path, frame);
  if (options_.leave_every == 0) return pose;
  const double phase = std::fmod(frame, options_.leave_every) - 0.5 * options_.leave_every;
  if (std::abs(phase) > kAwayFrames) return pose;
  const double part = 0.5 + 0.5 * std::cos(std::numbers::pi * phase / kAwayFrames);
  const double angle = kAwayDegrees * part * std::numbers::pi / 180;
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(angle, Vector3d::UnitY()).toRotationMatrix();
  return Rigid3d{turn, Vector3d::Zero()} * pose;
}

// What the first surface along a ray sends back.
float Film::LightAlong(const Eye& eye, const Vector3d& ray_in_cam) const {
  const Vector3d ray = eye.world_from_cam * ray_in_cam;
  if (ray.z() > -1e-3) return 0.35f;  // the wall
  for (const Disc& disc : discs_) {
    const Vector3d at = eye.center + (disc.center.z() - eye.center.z()) / ray.z() * ray;
    if ((at - disc.center).squaredNorm() > disc.radius * disc.radius) continue;
    if (options_.decoys) return Chequer(at.x(), at.y(), options_.board.square) ? kInk : kPaper;
    const auto cell = [&](double v) { return static_cast<int>(std::floor(v / 0.006)); };
    return 0.1f + 0.6f * synth::LatticeUniform(cell(at.x()), cell(at.y()), 3);
  }
  const Vector3d at = eye.center - eye.center.z() / ray.z() * ray;
  const auto light = static_cast<float>(1 + 0.8 * at.x());  // falls off to one side
  const double u = (at.x() + 0.5 * options_.board.width()) * print_per_metre_;
  const double v = (0.5 * options_.board.height() - at.y()) * print_per_metre_;
  if (u >= 0 && v >= 0 && u < print_.width() && v < print_.height()) {
    const auto paper = static_cast<float>(print_(static_cast<int>(u), static_cast<int>(v))) / 255.f;
    return light * (kInk + (kPaper - kInk) * paper);
  }
  const double out = kWhite * print_per_metre_;
  if (u > -out && v > -out && u < print_.width() + out && v < print_.height() + out)
    return light * kPaper;
  if (options_.decoys) return Chequer(at.x(), at.y(), options_.board.square) ? kInk : kPaper;
  const auto cell = [](double w) {
    return static_cast<int>(std::clamp(std::floor(w / 0.015), -1e6, 1e6));
  };
  return kCloth * (0.6f + 0.8f * synth::LatticeUniform(cell(at.x()), cell(at.y()), 1));
}

FilmFrame Film::Frame(int index) const {
  const Camera& c = options_.camera;
  FilmFrame frame;
  frame.cam_from_world = PoseAt(index);
  frame.picture.grey = Image<std::uint8_t>(c.width, c.height);
  frame.picture.full_range = true;
  const auto eye_at = [&](double time) {
    const Rigid3d world = PoseAt(time).Inverse();
    return Eye{world.translation, world.rotation};
  };
  const bool moving = options_.shutter > 0 || options_.readout > 0;
  std::vector<Eye> eyes(static_cast<std::size_t>(options_.samples), eye_at(index));
  std::size_t next = 0;
  for (int y = 0; y < c.height; ++y) {
    const double row = options_.readout * ((y + 0.5) / c.height - 0.5);
    for (int k = 0; moving && k < options_.samples; ++k) {
      if (y > 0 && options_.readout == 0) break;  // all rows see the same
      eyes[k] = eye_at(index + row + options_.shutter * ((k + 0.5) / options_.samples - 0.5));
    }
    for (int x = 0; x < c.width; ++x) {
      float light = 0;
      for (int k = 0; k < options_.samples; ++k) {
        const Eigen::Vector3f& ray = rays_[next++];
        if (ray.z() > 0) light += LightAlong(eyes[k], ray.cast<double>());
      }
      const std::uint64_t word = synth::Mix(synth::Mix(options_.seed + 1000003 * index) + next);
      const float noise = static_cast<float>(options_.noise_sigma) * Normal(word);
      frame.picture.grey(x, y) = Level(light / static_cast<float>(options_.samples), noise);
    }
  }
  CountCorners(&frame);
  return frame;
}

void Film::CountCorners(FilmFrame* frame) const {
  const Projector projector(options_.camera);
  constexpr double kBorder = 8;  // [px]
  for (const BoardCorner& corner : CornersOf(options_.board)) {
    const auto pixel = projector.Project(frame->cam_from_world * corner.point);
    if (!pixel || !options_.camera.Contains(*pixel, kBorder)) continue;
    ++frame->corners_in_view;
    frame->visible_corners += Hidden(frame->cam_from_world.Center(), corner.point) ? 0 : 1;
  }
}

namespace {

// As a camera that is turned by quarters about its axis sees it.
Image<std::uint8_t> Turned(const Image<std::uint8_t>& square, int quarters) {
  const int size = square.width();
  Image<std::uint8_t> turned(size, size);
  for (int y = 0; y < size; ++y) {
    for (int x = 0; x < size; ++x) {
      int u = x, v = y;
      for (int k = 0; k < quarters; ++k) u = size - 1 - std::exchange(v, u);
      turned(x, y) = square(u, v);
    }
  }
  return turned;
}

}  // namespace

std::vector<Image<std::uint8_t>> FilmFromAllSides(const Camera& camera) {
  if (camera.width != camera.height) throw std::invalid_argument("the picture must be square");
  std::vector<Image<std::uint8_t>> pictures;
  const std::vector<Vector3d> targets = {
      {0, 0, 0}, {0.14, 0.1, 0}, {-0.14, 0.1, 0}, {-0.14, -0.1, 0}, {0.14, -0.1, 0}};
  for (const Vector3d& target : targets) {
    FilmOptions options;
    options.camera = camera;
    options.path.frames = 8;
    options.path.arc_deg = 315;
    options.path.target = target;
    options.path.radius = 0.3;
    options.path.height = 0.42;
    options.noise_sigma = 2;
    options.samples = 4;
    const Film film(options);
    for (int i = 0; i < options.path.frames; ++i) {
      pictures.push_back(Turned(film.Frame(i).picture.grey, i % 4));
    }
  }
  return pictures;
}

}  // namespace livemvs
