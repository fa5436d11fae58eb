// The readers of unmodified nodes that a participant hears, so that people can be told why one of them is not
// served: DDS itself says nothing where names of types differ, and little where policies do.
#pragma once

#include <dds/dds.h>

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/sync/mutex.h"
#include "core/vanilla/vanilla_matching.h"

namespace sft::core {

class VanillaReaders {
 public:
  /// Ends with the participant, whose deletion waits until no listener runs any more.
  explicit VanillaReaders(dds_entity_t participant);
  VanillaReaders(const VanillaReaders&) = delete;
  VanillaReaders& operator=(const VanillaReaders&) = delete;

  /// Differs from what it was if others are there than before. Any thread.
  std::uint64_t changes() const { return changes_.load(std::memory_order_relaxed); }
  /// Those of that topic of DDS. Any thread.
  std::vector<VanillaReader> of(std::string_view topic) const;

 private:
  static constexpr std::size_t known_max = 4096;  ///< further ones are not looked at
  using Key = std::array<unsigned char, 16>;

  void take(dds_entity_t builtin);
  void note(const dds_builtintopic_endpoint_t& reader, const dds_sample_info_t& info) SFT_REQUIRES(mutex_);

  std::atomic<std::uint64_t> changes_{0};
  mutable Mutex mutex_;
  std::map<Key, std::pair<std::string, VanillaReader>> known_ SFT_GUARDED_BY(mutex_);  ///< with the topic
};

}  // namespace sft::core
