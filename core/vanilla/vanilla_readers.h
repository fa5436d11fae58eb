// The readers of unmodified nodes that a participant has discovered. They are kept so that the log can say
// why a reader is not served: DDS itself reports nothing if the names of types differ, and little if policies
// do.
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
  /// Must live until the participant is deleted. The deletion waits until no listener runs any more.
  explicit VanillaReaders(dds_entity_t participant);
  VanillaReaders(const VanillaReaders&) = delete;
  VanillaReaders& operator=(const VanillaReaders&) = delete;

  /// Returns a number that changes whenever a reader comes. Any thread.
  std::uint64_t changes() const { return changes_.load(std::memory_order_relaxed); }
  /// Returns the readers of that DDS topic. Any thread.
  std::vector<VanillaReader> of(std::string_view topic) const;

 private:
  static constexpr std::size_t known_max = 4096;  ///< further readers are ignored
  using Key = std::array<unsigned char, 16>;

  void take(dds_entity_t builtin);
  void note(const dds_builtintopic_endpoint_t& reader, const dds_sample_info_t& info) SFT_REQUIRES(mutex_);

  std::atomic<std::uint64_t> changes_{0};
  mutable Mutex mutex_;
  std::map<Key, std::pair<std::string, VanillaReader>> known_
      SFT_GUARDED_BY(mutex_);  ///< each with its topic
};

}  // namespace sft::core
