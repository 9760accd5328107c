#include "progress.h"

#include <unistd.h>

#include <cstdio>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace livemvs::app {
namespace {

constexpr auto kInterval = std::chrono::milliseconds(250);

}  // namespace

ProgressMode ParseProgressMode(const std::string& text) {
  if (text == "auto") return ProgressMode::kAuto;
  if (text == "line") return ProgressMode::kLine;
  if (text == "json") return ProgressMode::kJson;
  if (text == "none") return ProgressMode::kNone;
  throw std::invalid_argument("--progress " + text + ": must be auto, line, json or none");
}

Progress::Progress(ProgressMode mode) : mode_(mode) {
  if (mode_ == ProgressMode::kAuto) {
    mode_ = isatty(STDERR_FILENO) ? ProgressMode::kLine : ProgressMode::kNone;
  }
}

Progress::~Progress() {
  if (open_line_) std::fputc('\n', stderr);
}

void Progress::Show(const ProgressState& state) {
  state_ = state;
  pending_ = true;
  if (Clock::now() - last_ < kInterval) return;
  Print(state);
}

void Progress::ShowShare(const std::string& stage, double share) {
  ProgressState state;
  state.stage = stage;
  state.done = static_cast<std::int64_t>(100 * share);
  state.percent = true;
  Show(state);
}

void Progress::Finish() {
  if (pending_) Print(state_);
  if (open_line_) std::fputc('\n', stderr);
  open_line_ = false;
}

void Progress::Print(const ProgressState& state) {
  last_ = Clock::now();
  pending_ = false;
  if (state.percent) {
    PrintPercent(state);
    return;
  }
  const double seconds = std::chrono::duration<double>(last_ - start_).count();
  const double rate = seconds > 0 ? static_cast<double>(state.done) / seconds : 0;
  const double eta =
      rate > 0 && state.total > 0 ? static_cast<double>(state.total - state.done) / rate : -1;
  if (mode_ == ProgressMode::kJson) {
    nlohmann::json line = {{"stage", state.stage},
                           {"done", state.done},
                           {"total", state.total},
                           {"fps", rate},
                           {"seeds", state.seeds},
                           {"points", state.points}};
    if (eta >= 0) line["eta_s"] = eta;
    if (!state.note.empty()) line["note"] = state.note;
    std::fprintf(stderr,
                 "%s\n",
                 line.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace).c_str());
  } else if (mode_ == ProgressMode::kLine) {
    const std::string total = state.total > 0 ? "/" + std::to_string(state.total) : "";
    std::fprintf(stderr,
                 "\r%s: frame %lld%s, %.1f frames/s, %lld live seeds, %lld points",
                 state.stage.c_str(),
                 static_cast<long long>(state.done),
                 total.c_str(),
                 rate,
                 static_cast<long long>(state.seeds),
                 static_cast<long long>(state.points));
    if (eta >= 0) std::fprintf(stderr, ", %.0f s left", eta);
    if (!state.note.empty()) std::fprintf(stderr, " - %s", state.note.c_str());
    std::fputs("\x1b[K", stderr);
    std::fflush(stderr);
    open_line_ = true;
  }
}

void Progress::PrintPercent(const ProgressState& state) {
  if (mode_ == ProgressMode::kJson) {
    const nlohmann::json line = {{"stage", state.stage}, {"done", state.done}, {"total", 100}};
    std::fprintf(stderr, "%s\n", line.dump().c_str());
  } else if (mode_ == ProgressMode::kLine) {
    std::fprintf(
        stderr, "\r%s: %lld %%\x1b[K", state.stage.c_str(), static_cast<long long>(state.done));
    std::fflush(stderr);
    open_line_ = true;
  }
}

}  // namespace livemvs::app
