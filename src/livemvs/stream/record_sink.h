#pragma once

#include <cstdint>
#include <span>

#include "livemvs/stream/record.h"

namespace livemvs {

/// Takes the records of a stream as they arise: a journal, a viewer. Who implements it numbers
/// them, and returns at once: what takes long is done elsewhere.
class RecordSink {
 public:
  virtual ~RecordSink() = default;

  /// Called from one thread at a time. `payload` is valid during the call.
  virtual void Write(RecordType type, std::span<const std::uint8_t> payload) = 0;
};

}  // namespace livemvs
