// A cache of the decoded requests of readers to our writers. Every pair is evaluated again after every
// event. Decoding a request with parts or conditions again each time would take microseconds, and closing a
// mask takes many instructions. Uses no clock, thread or I/O.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

#include "core/control/control.h"
#include "sft/type_support.h"

namespace sft::core {

class RequestedSelections {
 public:
  /// Returns requested_selection() of this request. `type` is that of the writer. The result is valid until
  /// the next call.
  const Result<Selection>& of(const PairId& pair, const Request& request, const TypeSupport& type);
  void forget(EndpointId id) {
    std::erase_if(known_,
                  [&](const auto& item) { return item.first.writer == id || item.first.reader == id; });
  }
  /// Returns the number of requests that were decoded so far.
  std::uint64_t decoded() const { return decoded_; }

 private:
  struct Known {
    std::vector<std::uint64_t> mask_words;
    std::vector<std::byte> parts;
    Result<Selection> selection;

    bool is_of(const Request& request) const {
      return mask_words == request.mask_words && parts == request.parts;
    }
  };
  std::map<PairId, Known> known_;
  std::uint64_t decoded_ = 0;
};

}  // namespace sft::core
