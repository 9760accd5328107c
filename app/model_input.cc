#include "model_input.h"

#include <string>
#include <utility>

#include "livemvs/exchange/glb.h"
#include "livemvs/io/lower_case.h"

namespace livemvs::app {

namespace fs = std::filesystem;

bool IsModelName(const fs::path& path) {
  const std::string name = LowerCase(path.filename().string());
  return name.ends_with(".glb") || name.ends_with(".ply") || name.ends_with(".ply.gz");
}

PlyContents ReadModel(const fs::path& path) {
  if (LowerExtension(path) != ".glb") return ReadPly(path);
  ExchangeModel model = ReadGlb(path);
  PlyContents contents;
  contents.cloud = std::move(model.vertices);
  contents.faces = std::move(model.faces);
  contents.has_normals = model.has_normals;
  contents.has_colors = model.has_colors;
  return contents;
}

}  // namespace livemvs::app
