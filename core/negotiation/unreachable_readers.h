// Records the pairs of our writers and readers in shared memory whose reader the writer cannot notify of
// samples, and the reasons. Uses no clock, thread or I/O.
#pragma once

#include <map>
#include <string>
#include <utility>

#include "core/control/control.h"

namespace sft::core {

class UnreachableReaders {
 public:
  /// Stores `why_not`, a text for people, which is empty if the reader can be notified. Returns true if the
  /// state has changed.
  bool changed(const PairId& pair, const std::string& why_not) {
    if (why_not.empty()) return reasons_.erase(pair) != 0;
    return std::exchange(reasons_[pair], why_not) != why_not;
  }
  /// Returns why the reader cannot be notified; null if it can.
  const std::string* why(const PairId& pair) const {
    const auto reason = reasons_.find(pair);
    return reason == reasons_.end() ? nullptr : &reason->second;
  }
  void forget(EndpointId id) {
    std::erase_if(reasons_,
                  [&](const auto& item) { return item.first.writer == id || item.first.reader == id; });
  }

 private:
  std::map<PairId, std::string> reasons_;
};

}  // namespace sft::core
