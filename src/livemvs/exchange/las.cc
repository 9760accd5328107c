#include "livemvs/exchange/las.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <ctime>
#include <limits>
#include <stdexcept>
#include <vector>

#include "livemvs/io/atomic_file.h"
#include "livemvs/io/little_endian.h"

namespace livemvs {
namespace {

// LAS 1.4 R15. Sizes in bytes.
constexpr std::uint16_t kHeaderSize = 375;
constexpr std::uint16_t kPointSize = 36;  // of format 7
constexpr std::uint8_t kUint16 = 3, kFloat32 = 9;

void AppendText(std::string* bytes, const std::string& text, std::size_t size) {
  std::string field = text.substr(0, size);
  field.resize(size, '\0');
  *bytes += field;
}

/// How coordinates become whole numbers: value = offset + scale * whole.
struct Grid {
  double scale = 1;
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();

  std::int32_t Whole(double value, int axis) const {
    return static_cast<std::int32_t>(std::llround((value - offset[axis]) / scale));
  }
  double Value(std::int32_t whole, int axis) const { return offset[axis] + scale * whole; }
};

Grid GridOf(const Extent& extent) {
  constexpr double kSteps = 1e8;
  double size = extent.LongestSide();
  // A single point, or several in one place.
  if (!(size > 0)) size = std::max(extent.Center().cwiseAbs().maxCoeff(), 1.0);
  Grid grid;
  grid.scale = std::pow(10, std::floor(std::log10(size / kSteps)));
  const double coarse = grid.scale * kSteps;
  // Whole numbers of the coarse step read well; they lie within one step of the middle.
  grid.offset = (extent.Center() / coarse).array().round() * coarse;
  return grid;
}

struct ExtraField {
  const char* name;
  const char* description;
  std::uint8_t type;
};

std::vector<ExtraField> ExtraFields(bool normals) {
  std::vector<ExtraField> fields = {{"sigma", "standard deviation of depth", kFloat32},
                                    {"inlier_ratio", "confidence 0 ... 1", kFloat32},
                                    {"views", "frames that agreed", kUint16}};
  if (normals) {
    fields.push_back({"nx", "unit normal", kFloat32});
    fields.push_back({"ny", "unit normal", kFloat32});
    fields.push_back({"nz", "unit normal", kFloat32});
  }
  return fields;
}

std::uint16_t SizeOf(const std::vector<ExtraField>& fields) {
  int size = 0;
  for (const ExtraField& field : fields) size += field.type == kUint16 ? 2 : 4;
  return static_cast<std::uint16_t>(size);
}

std::string VariableRecord(const std::string& user,
                           std::uint16_t id,
                           const std::string& description,
                           const std::string& payload) {
  std::string bytes;
  AppendLittleEndian(&bytes, std::uint16_t{0});
  AppendText(&bytes, user, 16);
  AppendLittleEndian(&bytes, id);
  AppendLittleEndian(&bytes, static_cast<std::uint16_t>(payload.size()));
  AppendText(&bytes, description, 32);
  return bytes + payload;
}

std::string ExtraBytesRecord(const std::vector<ExtraField>& fields) {
  std::string payload;
  for (const ExtraField& field : fields) {
    payload.append(2, '\0');
    AppendLittleEndian(&payload, field.type);
    AppendLittleEndian(&payload, std::uint8_t{0});  // no "no data" value, range, scale or offset
    AppendText(&payload, field.name, 32);
    payload.append(4 + 5 * 24, '\0');
    AppendText(&payload, field.description, 32);
  }
  constexpr std::uint16_t kExtraBytes = 4;
  return VariableRecord("LASF_Spec", kExtraBytes, "Extra bytes", payload);
}

std::string CrsRecord(const std::string& wkt) {
  constexpr std::uint16_t kWkt = 2112;
  std::string payload = wkt;
  payload.push_back('\0');
  return VariableRecord("LASF_Projection", kWkt, "OGC WKT coordinate system", payload);
}

struct HeaderValues {
  std::uint32_t records = 0;
  std::uint32_t data_offset = 0;
  std::uint16_t point_size = 0;
  std::uint64_t points = 0;
  Grid grid;
  Eigen::Vector3d min, max;  ///< Of the positions as written.
};

std::string Header(const HeaderValues& h) {
  std::string bytes = "LASF";
  AppendLittleEndian(&bytes, std::uint16_t{0});   // file source
  AppendLittleEndian(&bytes, std::uint16_t{16});  // the coordinate system, if any, is WKT
  bytes.append(16, '\0');                         // GUID
  bytes += "\x01\x04";
  AppendText(&bytes, "EXTRACTION", 32);
  AppendText(&bytes, "livemvs", 32);
  const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  std::tm date{};
  gmtime_r(&now, &date);
  AppendLittleEndian(&bytes, static_cast<std::uint16_t>(date.tm_yday + 1));
  AppendLittleEndian(&bytes, static_cast<std::uint16_t>(date.tm_year + 1900));
  AppendLittleEndian(&bytes, kHeaderSize);
  AppendLittleEndian(&bytes, h.data_offset);
  AppendLittleEndian(&bytes, h.records);
  AppendLittleEndian(&bytes, std::uint8_t{7});
  AppendLittleEndian(&bytes, h.point_size);
  bytes.append(4 + 5 * 4, '\0');  // counts of the older form, which format 7 must leave 0
  for (int i = 0; i < 3; ++i) AppendLittleEndian(&bytes, h.grid.scale);
  for (int i = 0; i < 3; ++i) AppendLittleEndian(&bytes, h.grid.offset[i]);
  for (int i = 0; i < 3; ++i) {
    AppendLittleEndian(&bytes, h.max[i]);
    AppendLittleEndian(&bytes, h.min[i]);
  }
  bytes.append(8 + 8 + 4, '\0');  // no waveforms, no extended records
  AppendLittleEndian(&bytes, h.points);
  AppendLittleEndian(&bytes, h.points);  // first returns
  bytes.append(14 * 8, '\0');
  return bytes;
}

void AppendPoint(const Point& p, const Grid& grid, bool normals, std::string* bytes) {
  for (int i = 0; i < 3; ++i) AppendLittleEndian(bytes, grid.Whole(p.position[i], i));
  AppendLittleEndian(bytes, std::uint16_t{0});    // intensity
  AppendLittleEndian(bytes, std::uint8_t{0x11});  // return 1 of 1
  bytes->append(1 + 1 + 1 + 2 + 2, '\0');         // flags, class, user data, scan angle, source
  AppendLittleEndian(bytes, 0.0);                 // GPS time
  constexpr int kTo16Bits = 257;
  for (const std::uint8_t c : p.color) {
    AppendLittleEndian(bytes, static_cast<std::uint16_t>(c * kTo16Bits));
  }
  AppendLittleEndian(bytes, p.sigma);
  AppendLittleEndian(bytes, p.inlier_ratio);
  AppendLittleEndian(bytes, p.views);
  if (!normals) return;
  const Eigen::Vector3f n = UnitNormal(p);
  for (int i = 0; i < 3; ++i) AppendLittleEndian(bytes, n[i]);
}

}  // namespace

void WriteLas(const std::filesystem::path& path,
              const ExchangeModel& model,
              const LasOptions& options) {
  model.Check();
  if (model.IsMesh()) {
    throw std::invalid_argument(path.string() +
                                ": LAS carries points, and this is a mesh; write .glb, .obj or "
                                ".ply, or export the cloud");
  }
  if (options.crs_wkt.size() >= std::numeric_limits<std::uint16_t>::max()) {
    throw std::invalid_argument("--crs: the description is longer than the 65534 bytes of LAS");
  }
  const std::vector<ExtraField> fields = ExtraFields(model.has_normals);
  std::string records = ExtraBytesRecord(fields);
  if (!options.crs_wkt.empty()) records += CrsRecord(options.crs_wkt);
  const Extent extent = ExtentOf(model);
  HeaderValues h;
  h.records = options.crs_wkt.empty() ? 1 : 2;
  h.data_offset = static_cast<std::uint32_t>(kHeaderSize + records.size());
  h.point_size = static_cast<std::uint16_t>(kPointSize + SizeOf(fields));
  h.points = model.vertices.size();
  h.grid = GridOf(extent);
  for (int i = 0; i < 3; ++i) {
    h.min[i] = h.grid.Value(h.grid.Whole(extent.min[i], i), i);
    h.max[i] = h.grid.Value(h.grid.Whole(extent.max[i], i), i);
  }
  AtomicFile file(path);
  file.Write(Header(h));
  file.Write(records);
  std::string bytes;
  for (const Point& p : model.vertices) {
    bytes.clear();
    AppendPoint(p, h.grid, model.has_normals, &bytes);
    file.Write(bytes);
  }
  file.Commit();
}

}  // namespace livemvs
