#include "livemvs/synth/export.h"

#include <algorithm>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <memory>
#include <stdexcept>
#include <system_error>

#include "livemvs/core/error.h"
#include "livemvs/io/atomic_file.h"
#include "livemvs/io/calibration.h"
#include "livemvs/io/picture_codec.h"
#include "livemvs/io/ply.h"
#include "livemvs/io/video_writer.h"
#include "livemvs/synth/labels.h"

namespace livemvs {
namespace {

namespace fs = std::filesystem;

constexpr double kDepthUnit = 1e-3;  // of the PNG depth images [m]

[[gnu::format(printf, 1, 2)]] std::string Format(const char* format, ...) {
  char line[1024];
  va_list arguments;
  va_start(arguments, format);
  const int length = std::vsnprintf(line, sizeof line, format, arguments);
  va_end(arguments);
  return std::string(line, std::clamp<int>(length, 0, sizeof line - 1));
}

fs::path WriteText(const fs::path& path, const std::string& text) {
  AtomicFile file(path);
  file.Write(text);
  file.Commit();
  return path;
}

std::string PoseRow(std::int64_t frame, const Rigid3d& pose) {
  std::string row = std::to_string(frame);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) row += Format(" %.12g", pose.rotation(i, j));
    row += Format(" %.12g", pose.translation[i]);
  }
  return row + "\n";
}

fs::path WriteCamera(const fs::path& folder, const Camera& camera) {
  if (camera.model == CameraModel::kPinhole) {
    return WriteText(folder / "intrinsics.txt",
                     Format("%.12g %.12g %.12g %.12g %d %d\n",
                            camera.fx,
                            camera.fy,
                            camera.cx,
                            camera.cy,
                            camera.width,
                            camera.height));
  }
  WriteOpenCvYaml(folder / "camera.yaml", camera);
  return folder / "camera.yaml";
}

Image<Rgb> ToRgb(const Picture& picture) {
  Image<Rgb> rgb(picture.width(), picture.height());
  for (int y = 0; y < rgb.height(); ++y) {
    for (int x = 0; x < rgb.width(); ++x) rgb(x, y) = picture.ColorAt(x, y);
  }
  return rgb;
}

Image<std::uint16_t> ToDepthUnits(const Image<float>& z_depth) {
  Image<std::uint16_t> units(z_depth.width(), z_depth.height());
  for (int y = 0; y < units.height(); ++y) {
    for (int x = 0; x < units.width(); ++x) {
      const double value = std::round(z_depth(x, y) / kDepthUnit);
      units(x, y) = value <= 65535 ? static_cast<std::uint16_t>(value) : std::uint16_t{0};
    }
  }
  return units;
}

// The Portable Float Map: rows from the bottom up; the scale's sign says little-endian.
void WritePfm(const fs::path& path, const Image<float>& z_depth) {
  AtomicFile file(path);
  file.Write(Format("Pf\n%d %d\n-1.0\n", z_depth.width(), z_depth.height()));
  for (int y = z_depth.height() - 1; y >= 0; --y) {
    file.Write(z_depth.Row(y), sizeof(float) * static_cast<std::size_t>(z_depth.width()));
  }
  file.Commit();
}

std::string Readme(const SyntheticScene& scene,
                   const SequenceOptions& sequence,
                   const ExportOptions& options,
                   int frames) {
  const Box& box = scene.box();
  std::string text =
      "A synthetic sequence rendered by livemvs: poses, depth and mesh are exact.\n\n";
  if (!options.command.empty()) text += "Made by:\n  " + options.command + "\n\n";
  text += Format("%s: %d frames, %d x %d, %.6g per second.\n",
                 options.images ? "images/" : "video.mp4",
                 frames,
                 sequence.camera.width,
                 sequence.camera.height,
                 sequence.path.frames_per_second);
  text +=
      "poses.txt: frame, then the 3x4 matrix cam_from_world by rows; metres; camera axes x right, "
      "y down, z forward.\n";
  text += sequence.camera.model == CameraModel::kPinhole
              ? "intrinsics.txt: fx fy cx cy width height; pixel centres are integers.\n"
              : "camera.yaml: intrinsics and distortion in OpenCV's form; pixel centres are "
                "integers.\n";
  if (options.mesh) text += "mesh.ply: the true surface in the world, metres, z up.\n";
  if (options.depth_every > 0) {
    text +=
        "depth/NNNNNN.png: true z depth of frame NNNNNN, 16 bits, millimetres; 0: nothing there. "
        "The same exactly, in metres: depth/NNNNNN.pfm.\n";
  }
  if (options.labels_every > 0) {
    text +=
        "labels/NNNNNN.png: what makes the pixels of frame NNNNNN hard, the sum of 1 textureless, "
        "2 repetitive, 4 beside an occluding edge, 8 background, 16 specular, 32 soon occluded.\n";
  }
  return text + Format("\nBox of what is to be reconstructed: %g %g %g %g %g %g\n",
                       box.min.x(),
                       box.min.y(),
                       box.min.z(),
                       box.max.x(),
                       box.max.y(),
                       box.max.z());
}

// Whether something that is made of every N-th frame (0: of none) is made of this one.
bool IsDue(int every, int index) { return every > 0 && index % every == 0; }

// Takes the frames of a sequence, one after the other.
class FrameSink {
 public:
  FrameSink(const SequenceOptions& sequence, const ExportOptions& options) : options_(options) {
    if (options.images) {
      MakeFolder(options.folder / "images");
    } else {
      VideoWriterOptions video;
      video.width = sequence.camera.width;
      video.height = sequence.camera.height;
      video.frames_per_second = sequence.path.frames_per_second;
      video.crf = options.crf;
      video.preset = options.preset;
      video.keyframe_interval = 60;
      video_ = std::make_unique<VideoWriter>(options.folder / "video.mp4", video);
    }
    if (options.depth_every > 0) MakeFolder(options.folder / "depth");
    if (options.labels_every > 0) MakeFolder(options.folder / "labels");
  }

  /// @param labels  Of the frame, where they are due.
  void Write(const SyntheticFrame& frame, const Image<std::uint8_t>& labels) {
    const int index = static_cast<int>(frame.frame.index);
    const std::string name = Format("%06d", index);
    if (video_) {
      video_->Write(*frame.frame.picture);
    } else {
      WritePng(options_.folder / "images" / (name + ".png"), ToRgb(*frame.frame.picture));
    }
    if (IsDue(options_.depth_every, index)) {
      WritePng(options_.folder / "depth" / (name + ".png"), ToDepthUnits(frame.z_depth));
      WritePfm(options_.folder / "depth" / (name + ".pfm"), frame.z_depth);
    }
    if (IsDue(options_.labels_every, index)) {
      WritePng(options_.folder / "labels" / (name + ".png"), labels);
    }
    poses_ += PoseRow(index, frame.frame.cam_from_world);
  }

  std::vector<fs::path> Finish() {
    std::vector<fs::path> written;
    if (video_) video_->Finish();
    written.push_back(options_.folder / (video_ ? "video.mp4" : "images"));
    written.push_back(WriteText(options_.folder / "poses.txt", poses_));
    if (options_.depth_every > 0) written.push_back(options_.folder / "depth");
    if (options_.labels_every > 0) written.push_back(options_.folder / "labels");
    return written;
  }

 private:
  const ExportOptions& options_;
  std::unique_ptr<VideoWriter> video_;
  std::string poses_;
};

}  // namespace

void ExportOptions::Check() const {
  if (folder.empty()) throw std::invalid_argument("folder: none given");
  if (crf < 0 || crf > 51) throw std::invalid_argument("crf must be 0 to 51");
  if (depth_every < 0) throw std::invalid_argument("depth_every must not be negative");
  if (labels_every < 0) throw std::invalid_argument("labels_every must not be negative");
}

std::vector<fs::path> ExportSequence(const SyntheticScene& scene,
                                     const SequenceOptions& sequence,
                                     const ExportOptions& options) {
  sequence.Check();
  options.Check();
  if (!options.images && (sequence.camera.width % 2 != 0 || sequence.camera.height % 2 != 0)) {
    throw std::invalid_argument("a video's width and height must be even");
  }
  MakeFolder(options.folder);
  FrameSink sink(sequence, options);
  SequenceOptions quick = sequence;
  int done = 0;
  bool go_on = true;
  while (go_on && done < sequence.path.frames) {
    const bool labelled = IsDue(options.labels_every, done);
    quick.ground_truth = labelled || IsDue(options.depth_every, done);
    const SyntheticFrame frame = RenderSequenceFrame(scene, quick, done);
    sink.Write(frame,
               labelled ? LabelSequenceFrame(scene, sequence, frame) : Image<std::uint8_t>());
    ++done;
    if (options.progress) go_on = options.progress(done);
  }
  std::vector<fs::path> written = sink.Finish();
  written.push_back(WriteCamera(options.folder, sequence.camera));
  if (options.mesh) {
    WritePly(options.folder / "mesh.ply", scene.mesh());
    written.push_back(options.folder / "mesh.ply");
  }
  written.push_back(
      WriteText(options.folder / "README.txt", Readme(scene, sequence, options, done)));
  return written;
}

}  // namespace livemvs
