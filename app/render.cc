#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "commands.h"
#include "livemvs/core/error.h"
#include "livemvs/core/log.h"
#include "livemvs/eval/render.h"
#include "livemvs/io/atomic_file.h"
#include "livemvs/io/dataset.h"
#include "livemvs/io/picture_codec.h"
#include "model_input.h"

namespace livemvs::app {
namespace {

constexpr char kRenderExamples[] =
    "Without --view the picture is taken from where most of the cameras were, as the normals of\n"
    "the points tell. With --data, 'up' is what was up for the cameras.\n"
    "\n"
    "Examples:\n"
    "  livemvs render cloud.ply -o cloud.png\n"
    "  livemvs render cloud.ply -o sigma.png --color sigma --view top --unit m\n"
    "  livemvs render cloud.ply -o sheet.png --views 4 --up z --box -0.2 -0.1 0 0.2 0.1 0.2\n"
    "  livemvs render cloud.ply -o turn.png --turntable 36       (turn-00.png ... turn-35.png)\n"
    "  livemvs render cloud.ply -o frame.png --data recording --frame 100 --beside\n"
    "  livemvs render mesh.ply.gz -o mesh.png --view 1,-1,0.5";

struct RenderArguments {
  std::string input, output;
  std::string size = "1280x960";
  std::string view = "auto";
  std::string up;
  std::string color = "rgb";
  std::vector<double> box;
  std::string data;
  std::int64_t frame = -1;
  bool beside = false;
  int turntable = 0;
  int views = 1;
  bool no_scale_bar = false;
  ViewOptions fit;
  CloudRenderOptions options;
};

std::pair<int, int> ParseSize(const std::string& text) {
  int width = 0, height = 0;
  char rest = 0;
  if (std::sscanf(text.c_str(), "%5dx%5d%c", &width, &height, &rest) != 2) {
    throw std::invalid_argument("--size: '" + text + "' is not WIDTHxHEIGHT, as in 1280x960");
  }
  return {width, height};
}

/// A direction from "x,y,z" or from an axis: "z", "-y".
Eigen::Vector3d ParseDirection(const std::string& option, const std::string& text) {
  for (int axis = 0; axis < 3; ++axis) {
    const std::string name(1, static_cast<char>('x' + axis));
    if (text == name || text == "+" + name) return Eigen::Vector3d::Unit(axis);
    if (text == "-" + name) return -Eigen::Vector3d::Unit(axis);
  }
  Eigen::Vector3d v;
  char rest = 0;
  if (std::sscanf(text.c_str(), "%lf,%lf,%lf%c", &v.x(), &v.y(), &v.z(), &rest) != 3 ||
      !v.allFinite() || v.isZero()) {
    throw std::invalid_argument(option + ": '" + text + "' is not a direction, as in 0,0,1 or -y");
  }
  return v;
}

RenderColor ParseColor(const std::string& name) {
  if (name == "normal") return RenderColor::kNormal;
  if (name == "sigma") return RenderColor::kSigma;
  if (name == "inlier") return RenderColor::kInlierRatio;
  if (name == "height") return RenderColor::kHeight;
  return RenderColor::kRgb;
}

/// What is drawn: a cloud, or a mesh where `mesh.faces` is not empty.
class Scene {
 public:
  Scene(const PlyContents& contents,
        const std::optional<Box>& box,
        const CloudRenderOptions& options)
      : options_(options) {
    if (!contents.faces.empty()) {
      ReadMesh(contents, box);
      return;
    }
    for (const Point& p : contents.cloud) {
      if (!box || box->Contains(p.position.cast<double>())) points_.push_back(p);
    }
    towards_cameras_ = MeanViewingDirection(points_);
    renderer_.emplace(points_, options);
  }

  const PointCloud& points() const { return points_; }
  const Eigen::Vector3d& towards_cameras() const { return towards_cameras_; }

  /// Looks from where the cameras were, where the points do not tell.
  void UseViews(const std::vector<DatasetView>& views) {
    constexpr double kUnknown = 0.05;
    if (towards_cameras_.norm() > kUnknown) return;
    for (const DatasetView& v : views) {
      towards_cameras_ -=
          v.cam_from_world.rotation.row(2).transpose() / static_cast<double>(views.size());
    }
  }

  RgbImage Draw(const RenderView& view) const {
    return renderer_ ? renderer_->Draw(view) : RenderMesh(mesh_, view, options_);
  }

 private:
  void ReadMesh(const PlyContents& contents, const std::optional<Box>& box) {
    for (const Point& p : contents.cloud) {
      mesh_.vertices.push_back(p.position);
      if (contents.has_colors) mesh_.colors.push_back(p.color);
    }
    for (const Eigen::Vector3i& face : contents.faces) {
      bool inside = true;
      for (int corner = 0; corner < 3 && box; ++corner) {
        inside =
            inside &&
            box->Contains(mesh_.vertices[static_cast<std::size_t>(face[corner])].cast<double>());
      }
      if (inside) mesh_.faces.push_back(face);
    }
    if (mesh_.faces.empty()) return;
    constexpr std::size_t kFitSamples = 50000;
    for (const Eigen::Vector3f& p : MeshSurface(mesh_).Sample(kFitSamples, 1, box)) {
      points_.emplace_back().position = p;
    }
  }

  PointCloud points_;  ///< What the view is fitted to.
  Eigen::Vector3d towards_cameras_ = Eigen::Vector3d::Zero();
  TriangleMesh mesh_;
  std::optional<CloudRenderer> renderer_;
  CloudRenderOptions options_;
};

/// The view of a frame of the data set, to compare with its picture.
RenderView ViewOfFrame(const Dataset& dataset, std::int64_t frame, const Scene& scene) {
  for (const DatasetView& v : dataset.views()) {
    if (v.index != frame) continue;
    RenderView view;
    view.camera = v.camera;
    view.cam_from_world = v.cam_from_world;
    std::vector<double> depths;
    for (const Point& p : scene.points()) {
      const double z = (v.cam_from_world * p.position.cast<double>()).z();
      if (z > 0) depths.push_back(z);
    }
    if (!depths.empty()) {
      const auto middle = depths.begin() + static_cast<std::ptrdiff_t>(depths.size() / 2);
      std::nth_element(depths.begin(), middle, depths.end());
      view.focus_depth = *middle;
    }
    return view;
  }
  throw BadInput(dataset.description() + ": has no frame " + std::to_string(frame) +
                 "; see 'livemvs info'");
}

void Paste(const RgbImage& part, int x, int y, RgbImage* whole) {
  for (int row = 0; row < part.height() && y + row < whole->height(); ++row) {
    for (int column = 0; column < part.width() && x + column < whole->width(); ++column) {
      (*whole)(x + column, y + row) = part(column, row);
    }
  }
}

RgbImage PictureBeside(Dataset* dataset, std::int64_t frame, const RgbImage& drawn) {
  while (std::optional<PosedFrame> posed = dataset->Next()) {
    if (posed->index < frame) continue;
    if (posed->index > frame) break;
    RgbImage both(drawn.width() + posed->picture->width(), drawn.height());
    Paste(drawn, posed->picture->width(), 0, &both);
    for (int y = 0; y < std::min(both.height(), posed->picture->height()); ++y) {
      for (int x = 0; x < posed->picture->width(); ++x) {
        both(x, y) = posed->picture->ColorAt(x, y);
      }
    }
    return both;
  }
  throw BadInput(dataset->description() + ": frame " + std::to_string(frame) + " cannot be read");
}

/// Four views in one picture: as chosen, from both sides, from above.
RgbImage ContactSheet(const Scene& scene, ViewOptions fit) {
  RgbImage sheet = MakeRgbImage(fit.width, fit.height, {255, 255, 255});
  fit.width = fit.width / 2 - 1;
  fit.height = fit.height / 2 - 1;
  for (int i = 0; i < 4; ++i) {
    ViewOptions options = fit;
    if (i == 1) options.turn_deg += 50;
    if (i == 2) options.turn_deg -= 50;
    options.from_above = i == 3;
    options.level = options.level && i != 3;
    Paste(scene.Draw(FitView(scene.points(), scene.towards_cameras(), options)),
          i % 2 * (fit.width + 2),
          i / 2 * (fit.height + 2),
          &sheet);
  }
  return sheet;
}

std::string NumberedPath(const std::string& path, int index, int count) {
  const std::filesystem::path p(path);
  std::string number = std::to_string(index);
  number.insert(0, std::to_string(count - 1).size() - number.size(), '0');
  return (p.parent_path() / (p.stem().string() + "-" + number + p.extension().string())).string();
}

void WriteTurntable(const RenderArguments& args, const Scene& scene) {
  ViewOptions fit = args.fit;
  // One distance for all, or the object would breathe as it turns.
  const RenderView first = FitView(scene.points(), scene.towards_cameras(), fit);
  std::vector<RenderView> views;
  double depth = first.focus_depth;
  for (int i = 0; i < args.turntable; ++i) {
    fit.turn_deg = args.fit.turn_deg + 360.0 * i / args.turntable;
    views.push_back(FitView(scene.points(), scene.towards_cameras(), fit));
    depth = std::max(depth, views.back().focus_depth);
  }
  for (int i = 0; i < args.turntable; ++i) {
    RenderView& view = views[static_cast<std::size_t>(i)];
    view.cam_from_world.translation.z() += depth - view.focus_depth;
    view.focus_depth = depth;
    const std::string path = NumberedPath(args.output, i, args.turntable);
    WritePng(path, scene.Draw(view));
    std::printf("wrote %s\n", path.c_str());
  }
}

/// Everything that the words of the command line mean for the view.
void ParseArguments(RenderArguments* args) {
  std::tie(args->fit.width, args->fit.height) = ParseSize(args->size);
  args->options.color = ParseColor(args->color);
  args->options.scale_bar = !args->no_scale_bar;
  if (!args->up.empty()) args->fit.up = ParseDirection("--up", args->up);
  args->fit.level = args->view == "front";
  args->fit.from_above = args->view == "top";
  if (args->view != "auto" && !args->fit.level && !args->fit.from_above) {
    args->fit.direction = ParseDirection("--view", args->view);
  }
  if (args->views != 1 && args->views != 4) throw std::invalid_argument("--views: must be 1 or 4");
  if (args->frame >= 0 && args->data.empty()) {
    throw std::invalid_argument("--frame: needs --data");
  }
  if (args->beside && args->frame < 0) throw std::invalid_argument("--beside: needs --frame");
  args->fit.Check();
  args->options.Check();
}

void RunRender(RenderArguments args) {
  ParseArguments(&args);
  CheckWritable(args.output);
  std::optional<Box> box;
  if (!args.box.empty()) {
    box = Box{{args.box[0], args.box[1], args.box[2]}, {args.box[3], args.box[4], args.box[5]}};
  }
  std::unique_ptr<Dataset> dataset;
  if (!args.data.empty()) {
    DatasetOptions options;
    options.data = args.data;
    dataset = OpenDataset(options);
    std::vector<Rigid3d> cams_from_world;
    for (const DatasetView& v : dataset->views()) cams_from_world.push_back(v.cam_from_world);
    const Eigen::Vector3d up = UpOfCameras(cams_from_world);
    if (!args.fit.up && !up.isZero()) args.fit.up = up;
  }
  Scene scene(ReadModel(args.input), box, args.options);
  if (dataset) scene.UseViews(dataset->views());
  if (scene.points().empty()) {
    LogWarning(args.input + ": there is nothing to see" + (box ? " in the box" : ""));
  }
  if (args.turntable > 0) {
    WriteTurntable(args, scene);
    return;
  }
  RgbImage image;
  if (args.frame >= 0) {
    image = scene.Draw(ViewOfFrame(*dataset, args.frame, scene));
    if (args.beside) image = PictureBeside(dataset.get(), args.frame, image);
  } else if (args.views == 4) {
    image = ContactSheet(scene, args.fit);
  } else {
    image = scene.Draw(FitView(scene.points(), scene.towards_cameras(), args.fit));
  }
  WritePng(args.output, image);
  std::printf("wrote %s\n", args.output.c_str());
}

}  // namespace

void AddRenderCommand(CLI::App& app) {
  auto args = std::make_shared<RenderArguments>();
  CLI::App* command = app.add_subcommand("render", "Draw a cloud or mesh as a picture.");
  command->footer(kRenderExamples);
  command->add_option("CLOUD", args->input, "Cloud or mesh (.ply, .ply.gz, .glb)")->required();
  command->add_option("-o,--output", args->output, "Picture to write (.png)")->required();
  command->add_option("--size", args->size, "Size of the picture [px]")->capture_default_str();
  command
      ->add_option("--view", args->view, "auto, front, top, or the direction x,y,z to the viewer")
      ->capture_default_str();
  command->add_option(
      "--up", args->up, "What is up: x, -x, y, -y, z, -z or x,y,z (default: guessed)");
  command->add_option("--turn", args->fit.turn_deg, "Turn the viewer about 'up' [deg]");
  command->add_option("--color", args->color, "rgb, normal, sigma, inlier, height")
      ->check(CLI::IsMember({"rgb", "normal", "sigma", "inlier", "height"}))
      ->capture_default_str();
  command->add_option("--box", args->box, "Draw this box only: x0 y0 z0 x1 y1 z1 [scene]")
      ->expected(6);
  command->add_option("--point-size", args->options.point_size, "Multiple of the automatic size")
      ->capture_default_str();
  command->add_option("--views", args->views, "4: four views in one picture")
      ->capture_default_str();
  command->add_option("--turntable", args->turntable, "Write N pictures, once around")
      ->check(CLI::Range(1, 10000));
  command->add_option(
      "--data,--camera-of", args->data, "Data set with the cameras that filmed this");
  command->add_option("--frame", args->frame, "Draw as this frame of --data saw it")
      ->check(CLI::NonNegativeNumber);
  command->add_flag("--beside", args->beside, "Put the frame's picture to the left");
  command->add_option("--unit", args->options.unit, "Name of the scene unit, for the labels");
  command->add_option("--supersampling", args->options.supersampling, "Samples per pixel each way")
      ->capture_default_str();
  command->add_flag("--no-scale-bar", args->no_scale_bar, "Leave the scale bar out");
  command->add_flag(
      "--plain-normals", args->options.plain_normals, "Shade with the cloud's normals as they are");
  command->callback([args] { RunRender(*args); });
}

}  // namespace livemvs::app
