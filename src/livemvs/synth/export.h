#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "livemvs/synth/scene.h"
#include "livemvs/synth/sequence.h"

namespace livemvs {

struct ExportOptions {
  std::filesystem::path folder;  ///< Made where it does not exist.
  bool images = false;           ///< images/NNNNNN.png instead of video.mp4.
  int crf = 20;                  ///< Quality of the H.264 video: 0 lossless ... 51 worst.
  std::string preset = "slow";   ///< Speed of the encoder.
  int depth_every = 0;           ///< Depth of every N-th frame; 0: none.
  int labels_every = 0;          ///< PixelLabels of every N-th frame; 0: none.
  bool mesh = true;              ///< Write the true surface.
  std::string command;           ///< For README.txt: how the folder was made.
  /// Called after each frame with the number done; false stops, and the frames so far are kept.
  std::function<bool(int)> progress;

  void Check() const;  ///< @throws std::invalid_argument
};

/// Renders a sequence into a folder that OpenDataset() reads: the video or images, poses.txt
/// (frame, 3x4 cam_from_world by rows), intrinsics.txt or (with distortion) camera.yaml, and beside
/// them the truth: mesh.ply in the world, z depth as depth/NNNNNN.png (16 bits, millimetres; 0:
/// nothing) and depth/NNNNNN.pfm (metres), what makes pixels hard as labels/NNNNNN.png (8 bits:
/// PixelLabels), and README.txt.
/// @return The paths written, the folder of depths once.
/// @throws Error (kOutOfResource) where a file cannot be written.
std::vector<std::filesystem::path> ExportSequence(const SyntheticScene& scene,
                                                  const SequenceOptions& sequence,
                                                  const ExportOptions& options);

}  // namespace livemvs
