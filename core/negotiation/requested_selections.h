// What readers ask of our writers for, as it was understood last. Every pair is judged again after every
// event: what has parts or conditions takes microseconds to decode, and a mask many instructions to close.
// Pure.
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
  /// As requested_selection() says it. `type` is that of the writer. Valid until the next call.
  const Result<Selection>& of(const PairId& pair, const Request& request, const TypeSupport& type);
  void forget(EndpointId id) {
    std::erase_if(known_,
                  [&](const auto& item) { return item.first.writer == id || item.first.reader == id; });
  }
  /// The number of requests that were decoded so far.
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
