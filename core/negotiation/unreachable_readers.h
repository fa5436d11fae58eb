// Keeps which readers in shared memory cannot be told of samples by which of our writers, and why. Pure.
#pragma once

#include <map>
#include <string>
#include <utility>

#include "core/control/control.h"

namespace sft::core {

class UnreachableReaders {
 public:
  /// `why_not` is for people, and empty if the reader is reached. Returns true if that is news.
  bool changed(const PairId& pair, const std::string& why_not) {
    if (why_not.empty()) return reasons_.erase(pair) != 0;
    return std::exchange(reasons_[pair], why_not) != why_not;
  }
  /// Null if the reader is reached.
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
