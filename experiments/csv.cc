#include "csv.h"

#include "livemvs/core/error.h"

namespace livemvs::experiments {

Csv::Csv(const std::filesystem::path& path, const std::string& header) : path_(path), file_(path) {
  Write(header + "\n");
}

void Csv::Write(const std::string& line) {
  file_ << line;
  if (!file_) throw Error(ErrorKind::kOutOfResource, path_.string() + ": cannot be written");
}

}  // namespace livemvs::experiments
