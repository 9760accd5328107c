#include "livemvs/exchange/obj.h"

#include <cstdio>
#include <stdexcept>
#include <string>

#include "livemvs/io/atomic_file.h"

namespace livemvs {
namespace {

namespace fs = std::filesystem;

constexpr char kMaterial[] =
    "# livemvs: the colours are those of the vertices\n"
    "newmtl surface\n"
    "Kd 1 1 1\n"
    "Ks 0 0 0\n"
    "illum 1\n";

void WriteVertices(const ExchangeModel& model, AtomicFile& file) {
  char line[160];
  for (const Point& v : model.vertices) {
    const Eigen::Vector3f& p = v.position;
    // Nine digits give a float back exactly; five tell the 256 levels of a colour apart.
    int length = std::snprintf(line, sizeof line, "v %.9g %.9g %.9g", p.x(), p.y(), p.z());
    if (model.has_colors) {
      length += std::snprintf(line + length,
                              sizeof line - static_cast<std::size_t>(length),
                              " %.5g %.5g %.5g",
                              v.color[0] / 255.0,
                              v.color[1] / 255.0,
                              v.color[2] / 255.0);
    }
    line[length++] = '\n';
    file.Write(line, static_cast<std::size_t>(length));
  }
  for (std::size_t i = 0; model.has_normals && i < model.vertices.size(); ++i) {
    const Eigen::Vector3f n = UnitNormal(model.vertices[i]);
    const int length = std::snprintf(line, sizeof line, "vn %.6g %.6g %.6g\n", n.x(), n.y(), n.z());
    file.Write(line, static_cast<std::size_t>(length));
  }
}

void WriteFaces(const ExchangeModel& model, AtomicFile& file) {
  for (const Eigen::Vector3i& face : model.faces) {
    std::string line = "f";
    for (int i = 0; i < 3; ++i) {
      const std::string number = std::to_string(face[i] + 1);
      line += " " + number;
      if (model.has_normals) line += "//" + number;
    }
    file.Write(line + "\n");
  }
}

}  // namespace

void WriteObj(const fs::path& path, const ExchangeModel& model) {
  model.Check();
  if (!model.IsMesh()) {
    throw std::invalid_argument(path.string() +
                                ": OBJ carries meshes, and this is a cloud without faces; write "
                                ".ply, .glb or .las, or make a mesh of it first");
  }
  fs::path material = path;
  material.replace_extension(".mtl");
  const std::string name = material.filename().string();
  if (name.find_first_of("\n\r") != std::string::npos) {
    throw std::invalid_argument(path.string() + ": OBJ cannot refer to a name with line breaks");
  }
  AtomicFile material_file(material);
  AtomicFile file(path);
  material_file.Write(kMaterial);
  file.Write("# livemvs\nmtllib " + name + "\n");
  WriteVertices(model, file);
  file.Write("usemtl surface\n");
  WriteFaces(model, file);
  material_file.Commit();
  try {
    file.Commit();
  } catch (...) {
    std::error_code ignored;
    fs::remove(material, ignored);
    throw;
  }
}

}  // namespace livemvs
