#include "core/discovery/remote_table.h"

#include <algorithm>
#include <utility>

namespace sft::core {

void RemoteTable::put(const RecordKey& key, Record record) {
  records_.put(key, std::move(record));
  const std::uint64_t digest = records_.digest();
  passed_.push_back(digest);
  if (passed_.size() > passed_max) passed_.pop_front();
  const auto met = std::ranges::find(expected_.rbegin(), expected_.rend(), digest, &Expected::digest);
  expected_.erase(expected_.begin(), met.base());
}

bool RemoteTable::expect(std::uint64_t digest, Time::duration apart, Time now) {
  if (digest == records_.digest()) {
    passed_.clear();
    expected_.clear();
    return true;
  }
  if (const auto passed = std::ranges::find(passed_, digest); passed != passed_.end()) {
    passed_.erase(passed_.begin(), passed + 1);
    expected_.clear();
    return true;
  }
  if (!expected_.empty() && now - expected_.back().since < apart) {
    expected_.back().digest = digest;
    return false;
  }
  expected_.push_back({digest, now});
  // behind_since() needs the first two digests, so they are kept. Of the later digests the oldest is
  // removed, because the table is most likely to reach the newest ones.
  if (expected_.size() > expected_max) expected_.erase(expected_.begin() + 2);
  return false;
}

std::optional<Time> RemoteTable::behind_since() const {
  return expected_.size() < 2 ? std::nullopt : std::optional(expected_[1].since);
}

}  // namespace sft::core
