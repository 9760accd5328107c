// Uses the library as a stranger would, from the installed package alone: renders a scene,
// reconstructs it, writes the cloud and reads it back.
#include <cmath>
#include <cstdio>
#include <filesystem>

#include "livemvs/io/ply.h"
#include "livemvs/pipeline/reconstructor.h"
#include "livemvs/synth/sequence.h"

int main() {
  const livemvs::SyntheticScene scene({.name = "plane"});
  livemvs::SequenceOptions sequence;
  sequence.path = livemvs::DefaultPath("plane");
  sequence.path.frames = 40;
  sequence.path.arc_deg = 30;
  sequence.camera = livemvs::SyntheticCamera(240, 180);
  sequence.samples_per_pixel = 1;
  sequence.ground_truth = false;

  livemvs::SceneRange range;
  range.near = 0.3;
  range.far = 1.5;
  livemvs::Reconstructor reconstructor(livemvs::DefaultOptions(), range);
  for (int i = 0; i < sequence.path.frames; ++i) {
    reconstructor.AddFrame(livemvs::RenderSequenceFrame(scene, sequence, i).frame);
  }

  const std::filesystem::path file = "cloud.ply";
  livemvs::WritePly(file, reconstructor.points(), "towards the first camera");
  const livemvs::PointCloud cloud = livemvs::ReadPly(file).cloud;
  int near_plane = 0;
  for (const livemvs::Point& point : cloud) near_plane += std::abs(point.position.z()) < 0.01F;
  std::printf("%zu points, %d of them within 1 cm of the plane\n", cloud.size(), near_plane);
  return cloud.size() > 100 && near_plane > 0.9 * static_cast<double>(cloud.size()) ? 0 : 1;
}
