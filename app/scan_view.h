#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "live_view.h"
#include "livemvs/scan/scan.h"
#include "scan_arguments.h"
#include "scan_folder.h"
#include "scan_input.h"

namespace livemvs::app {

/// What 'scan' shows while it works, if anything: the viewer, which gets the journal's records,
/// those of before among them, and the camera's picture also while it is lost.
class ScanView {
 public:
  ScanView(const ScanArguments& args, const ScanFolder& folder, const ScanInput& input);

  /// Joins a scan that is about to begin, and what it is watched by. Waits for the page to say
  /// start where that was asked for.
  /// @param session  The journal's first record.
  void Join(const std::vector<std::uint8_t>& session, Scan* scan, Scan::Watch* watch);
  void ShowProgress(const ScanProgress& progress);
  /// Whether the page said finish.
  bool finish_asked() const { return view_ != nullptr && view_->finish_asked(); }
  /// Nothing follows; the pages are given the time to hear how it ended.
  void End(const ScanResult& result);
  /// Keeps serving until a signal comes.
  void Linger();

 private:
  void ShowFrame(const PosedFrame& frame,
                 std::span<const Point> converged,
                 const Reconstructor& reconstructor);

  std::unique_ptr<LiveView> view_;
  viewer::LiveCounts counts_;
  bool live_ = false;
};

}  // namespace livemvs::app
