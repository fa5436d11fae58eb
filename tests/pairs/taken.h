// Counts the samples that a subscriber took, by writer, and checks that they have the published content.
#pragma once

#include <sft/sft.h>

#include <cstdint>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/pairs/message.h"

namespace sft::test {

/// Any thread may call any function.
class Taken {
 public:
  /// Counts the sample, and checks that its bytes are those of the message whose number is the sample's
  /// sequence.
  template <Req<PointCloud2> R>
  void note(const Sample<PointCloud2, R>& sample) {
    note(sample.info(), sample.mask(), is_message(sample.info().sequence, sample.mask(), sample.cdr()));
  }

  nlohmann::json to_json() const;

 private:
  struct OfWriter {
    std::uint64_t first = 0;  ///< the sequence of the first sample
    std::uint64_t last = 0;
    std::uint64_t received = 0;
    std::uint64_t by_shm = 0;
    std::uint64_t wrong = 0;       ///< the number of samples with wrong bytes for the mask that they name
    std::uint64_t disordered = 0;  ///< the number of samples that arrived after a later one, or twice
    std::map<std::string, std::uint64_t> masks{};
    std::string last_mask{};
  };
  void note(const SampleInfo& info, const FieldMask& mask, bool right);

  mutable std::mutex mutex_;
  std::map<std::uint64_t, OfWriter> writers_;
};

}  // namespace sft::test
