#include "core/discovery/records.h"

#include <algorithm>
#include <cstring>
#include <utility>

namespace sft::core {

namespace {

/// Spreads each bit of a number over all bits (the finalizer of splitmix64).
constexpr std::uint64_t spread(std::uint64_t number) {
  number = (number ^ (number >> 30)) * 0xbf58476d1ce4e5b9U;
  number = (number ^ (number >> 27)) * 0x94d049bb133111ebU;
  return number ^ (number >> 31);
}

/// Returns what one record adds to the digest, where the digest is the sum over all records.
std::uint64_t digest_of(const RecordKey& key, const Record& record) {
  std::uint64_t digest = spread((std::uint64_t{key.slot} << 8) + static_cast<std::uint64_t>(key.kind) + 1);
  digest = spread(digest ^ record.revision);
  if (record.is_withdrawn()) return digest;
  digest = spread(digest + record.body->size() + 1);
  for (std::size_t at = 0; at < record.body->size(); at += sizeof(std::uint64_t)) {
    std::uint64_t word = 0;
    std::memcpy(&word, record.body->data() + at, std::min(sizeof word, record.body->size() - at));
    digest = spread(digest ^ word);
  }
  return digest;
}

}  // namespace

bool operator==(const Record& a, const Record& b) {
  if (a.revision != b.revision || a.is_withdrawn() != b.is_withdrawn()) return false;
  return a.body == b.body || *a.body == *b.body;
}

void Records::put(const RecordKey& key, Record record) {
  erase(key);
  digest_ += digest_of(key, record);
  bytes_ += record.bytes();
  all_.emplace(key, std::move(record));
}

void Records::erase(const RecordKey& key) {
  const auto found = all_.find(key);
  if (found == all_.end()) return;
  digest_ -= digest_of(key, found->second);
  bytes_ -= found->second.bytes();
  all_.erase(found);
}

const Record* Records::find(const RecordKey& key) const {
  const auto found = all_.find(key);
  return found == all_.end() ? nullptr : &found->second;
}

}  // namespace sft::core
