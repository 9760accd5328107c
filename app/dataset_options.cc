#include "dataset_options.h"

#include <map>
#include <string>

namespace livemvs::app {

CLI::Option* AddDatasetOptions(CLI::App* command, DatasetOptions* options) {
  static const std::map<std::string, PoseConvention> kConventions = {
      {"auto", PoseConvention::kAuto},
      {"cam-from-world", PoseConvention::kCamFromWorld},
      {"world-from-cam", PoseConvention::kWorldFromCam},
      {"world-from-cam-opengl", PoseConvention::kWorldFromCamOpenGl}};
  CLI::Option* data =
      command->add_option("--data", options->data, "Data set folder, or a video")->required();
  command->add_option("--poses", options->poses, "Pose file: TUM or 3x4 rows");
  command->add_option("--images", options->images, "Folder of the images, where not the usual one");
  command->add_option(
      "--camera", options->camera, "OpenCV YAML file, or fx,fy,cx,cy[,k1,k2,p1,p2[,k3...]]");
  command
      ->add_option("--pose-convention",
                   options->pose_convention,
                   "auto, cam-from-world, world-from-cam or world-from-cam-opengl")
      ->transform(CLI::CheckedTransformer(kConventions));
  command->add_option("--first-frame", options->first_frame, "First frame to use");
  command->add_option("--last-frame", options->last_frame, "Last frame to use");
  command->add_option("--step", options->step, "Use every n-th frame");
  return data;
}

}  // namespace livemvs::app
