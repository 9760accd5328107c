// Measures the tracker under the conditions of docs/tracking.md: a board filmed with distortion,
// blur, noise, things on it, compression and decoys, every pose compared with the true one.
//
//   track_conditions [FRAMES [WIDTHxHEIGHT[xSAMPLES] [CONDITION...]]]
//
// SAMPLES per pixel (8; twice as many with blur) may be fewer where only wrong poses are counted.

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "livemvs/io/video_source.h"
#include "livemvs/io/video_writer.h"
#include "livemvs/synth/sequence.h"
#include "livemvs/tracking/board_tracker.h"
#include "livemvs/tracking/film.h"
#include "livemvs/tracking/track_score.h"

namespace livemvs {
namespace {

struct Condition {
  std::string name;
  FilmOptions film;
  int crf = -1;  // of H.264; -1: as rendered
  bool self_calibrated = false;
};

FilmOptions Plain(int frames, int width, int height) {
  FilmOptions film;
  film.camera = SyntheticCamera(width, height);
  film.path.frames = frames;
  film.path.target = {0, 0, 0.02};
  film.path.radius = 0.42;
  film.path.height = 0.36;
  // Goes around at the same pace however long.
  film.path.arc_deg = 100.0 * frames / 240;
  return film;
}

FilmOptions With(FilmOptions film, const std::vector<double>& distortion) {
  film.camera.model = CameraModel::kBrownConrady;
  std::copy(distortion.begin(), distortion.end(), film.camera.distortion.begin());
  return film;
}

std::vector<Condition> Conditions(int frames, int width, int height, int samples) {
  FilmOptions plain = Plain(frames, width, height);
  plain.samples = samples;
  std::vector<Condition> all{{"plain", plain}};
  all.push_back({"distortion", With(plain, {-0.25, 0.08, 0.001, -0.0005})});
  all.push_back({"noise", plain});
  all.back().film.noise_sigma = 6;
  all.push_back({"blur", plain});
  all.back().film.shutter = 0.5;
  all.back().film.path.wobble = 3;
  all.back().film.samples = 2 * samples;
  all.push_back({"shake", all.back().film});
  all.back().film.path.wobble = 12;
  all.push_back({"hidden", plain});
  all.back().film.hidden = 0.3;
  all.push_back({"compression", plain, 32});
  all.push_back({"all", With(plain, {-0.25, 0.08, 0.001, -0.0005}), 28});
  all.back().film.noise_sigma = 4;
  all.back().film.shutter = 0.5;
  all.back().film.path.wobble = 2;
  all.back().film.samples = 2 * samples;
  all.back().film.hidden = 0.3;
  all.push_back({"decoys", plain, 23});
  all.back().film.noise_sigma = 3;
  all.back().film.hidden = 0.3;
  all.back().film.decoys = true;
  all.back().film.leave_every = 120;
  all.push_back({"rolling", plain});
  all.back().film.readout = 0.6;
  all.back().film.noise_sigma = 2;
  all.push_back({"self", With(plain, {-0.1, 0.02}), -1, true});
  all.back().film.noise_sigma = 2;
  return all;
}

// Time of a processor that this thread took: other work on the machine does not count.
double ThreadMilliseconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

// Writes the film as a video; what is known of its frames goes to `truths`, without pictures.
std::filesystem::path Compress(const Film& film,
                               const Condition& condition,
                               std::vector<FilmFrame>* truths) {
  const auto path =
      std::filesystem::temp_directory_path() / ("livemvs-track-" + condition.name + ".mp4");
  VideoWriter writer(path,
                     {.width = condition.film.camera.width,
                      .height = condition.film.camera.height,
                      .crf = condition.crf,
                      .preset = "fast"});
  for (int i = 0; i < condition.film.path.frames; ++i) {
    FilmFrame frame = film.Frame(i);
    writer.Write(frame.picture.grey);
    frame.picture = {};
    truths->push_back(std::move(frame));
  }
  writer.Finish();
  return path;
}

void Measure(const Condition& condition) {
  const Film film(condition.film);
  std::filesystem::path video;
  std::unique_ptr<FrameSource> source;
  std::vector<FilmFrame> truths;
  if (condition.crf >= 0) {
    video = Compress(film, condition, &truths);
    source = OpenVideo(video);
  }
  const Camera& camera = condition.film.camera;
  const auto tracker = MakeBoardTracker(
      condition.film.board, condition.self_calibrated ? std::nullopt : std::optional(camera));
  TrackScore score(BoxAbove(condition.film.board, 0.12));
  std::vector<double> times;
  double blur = 0;
  for (int i = 0; i < condition.film.path.frames; ++i) {
    FilmFrame frame = source ? std::move(truths[i]) : film.Frame(i);
    if (source) {
      const auto read = source->Next();
      if (!read) break;
      frame.picture.grey = Image<std::uint8_t>(camera.width, camera.height);
      for (int y = 0; y < camera.height; ++y) {
        std::copy_n(read->picture->grey.Row(y), camera.width, frame.picture.grey.Row(y));
      }
    }
    const double start = ThreadMilliseconds();
    const PoseEstimate e = tracker->Estimate(frame.picture, i / 30.0);
    const double took = ThreadMilliseconds() - start;
    times.push_back(took);
    blur = std::max(blur, e.blur_px);
    score.Add(e, camera, frame.cam_from_world, frame.visible_corners);
  }
  if (!video.empty()) std::filesystem::remove(video);
  std::sort(times.begin(), times.end());
  std::printf("%-12s %s; blur to %.1f px; f %.2f of %.2f; %.2f ms median, %.2f ms 99 %%\n",
              condition.name.c_str(),
              score.Summary().c_str(),
              blur,
              tracker->camera().fx,
              camera.fx,
              times[times.size() / 2],
              times[times.size() * 99 / 100]);
  std::fflush(stdout);
}

int Main(int argc, char** argv) {
  const int frames = argc > 1 ? std::atoi(argv[1]) : 240;
  int width = 960, height = 720, samples = 8;
  if (argc > 2 && std::sscanf(argv[2], "%dx%dx%d", &width, &height, &samples) < 2) return 2;
  const std::vector<std::string> wanted(argv + std::min(argc, 3), argv + argc);
  for (const Condition& condition : Conditions(std::max(2, frames), width, height, samples)) {
    if (wanted.empty() || std::find(wanted.begin(), wanted.end(), condition.name) != wanted.end()) {
      Measure(condition);
    }
  }
  return 0;
}

}  // namespace
}  // namespace livemvs

int main(int argc, char** argv) { return livemvs::Main(argc, argv); }
